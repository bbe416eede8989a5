// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/build_params.h>
#include <mrpt/fusion/fusion_view.h>
#include <mrpt/fusion/poses.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "top_view.h"

namespace mrpt::maps {
class CMetricMap;
}
namespace mrpt::obs {
class CObservationLocalMap;
}

/** A map to work on. */
struct LoadedMap {
  std::shared_ptr<const octomap::OcTree> octree;          ///< of it, or of its edges
  std::shared_ptr<const mrpt::fusion::EdgeVoxels> edges;  ///< if it is edges alone
  std::shared_ptr<mrpt::maps::CMetricMap> mrpt;           ///< as it was read, if it was MRPT's

  mrpt::fusion::MapView view() const {
    return edges ? mrpt::fusion::MapView{nullptr, edges.get()}
                 : mrpt::fusion::MapView{octree.get(), nullptr};
  }
};

/** A robot's map. */
struct Robot {
  std::string name;
  LoadedMap map;
  mrpt::poses::CPose3DPDFGaussian pose = mrpt::fusion::noGuess();  ///< see RobotMap
  std::shared_ptr<const mrpt::obs::CObservationLocalMap> sent;     ///< if it is from a mission
};

/** What was built of a recording. */
struct BuiltMap {
  LoadedMap map;  ///< without an octree, if it is of another kind
  size_t inserted, ignored;
};

/** What of a run needs MRPT's map classes. They bring some 280 libraries, a third of a second and
 * 100 MB: they are in a module that is loaded when a run asks for it. All throw std::exceptions,
 * with "<path>: <reason>" if it is a file's fault. */
class MrptMaps {
 public:
  virtual ~MrptMaps() = default;

  /** A map from a file that is no octree's. */
  virtual LoadedMap load(const std::string& path,
                         const mrpt::fusion::BuildParams& params) const = 0;
  /** The last map of each robot in a recorded mission; none if the file is something else. */
  virtual std::vector<Robot> loadMission(const std::string& path) const = 0;
  virtual void saveMission(const std::vector<Robot>& robots, const std::string& path) const = 0;
  /** Makes a map of a recording. */
  virtual BuiltMap build(const std::string& recording,
                         const mrpt::fusion::BuildParams& params) const = 0;
  /** See mrpt::fusion::saveMap(). */
  virtual void save(const LoadedMap& map, const std::string& path) const = 0;
  virtual void drawScene(const mrpt::fusion::FusionView& view, const std::string& path) const = 0;
  /** See drawTopView(). */
  virtual void drawPicture(const mrpt::fusion::OccupiedVoxels& a,
                           const mrpt::fusion::OccupiedVoxels& b,
                           const std::vector<TopViewPanel>& panels,
                           const std::string& path) const = 0;
};

/** Loads the module at the first call. \exception std::runtime_error If it cannot be. */
const MrptMaps& mrptMaps();
