// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/poses.h>
#include <octomap/OcTree.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fusion_octree/slice.h"
#include "fusion_report/pose_graph.h"
#include "fusion_report/report.h"

namespace mrpt::fusion {
struct MapDiff;
}
namespace mrpt::config {
class CConfigFileBase;
}
namespace mrpt::maps {
class CMetricMap;
}
namespace mrpt::obs {
class CObservationLocalMap;
}

/** \file
 * The interface to MRPT's map classes. They bring some 280 libraries, a third of a second and 100
 * MB. So they are in a module, which is loaded when a run needs it. */

namespace map_fusion {

/** A map of a run. */
struct LoadedMap {
  std::shared_ptr<const octomap::OcTree> octree;          ///< The map, or its edges as voxels
  std::shared_ptr<const mrpt::fusion::EdgeVoxels> edges;  ///< Edges; null if the map is whole
  std::shared_ptr<mrpt::maps::CMetricMap> mrpt;           ///< MRPT's map, if the file has one
  std::vector<std::string> notes;  ///< Differences between the file and the map
  /** Sources of the map. A map of a file has at least one, see mrpt::fusion::SourceId. */
  mrpt::fusion::Sources sources = {};

  /** Prepares the map for matching. */
  mrpt::fusion::PreparedMap prepared(const mrpt::fusion::FeatureParams& params) const {
    return edges ? mrpt::fusion::PreparedMap(*edges, params)
                 : mrpt::fusion::PreparedMap(octree, params).withSources(sources);
  }
  /** Returns the map. \exception std::runtime_error If only edges are known. */
  const octomap::OcTree& wholeMap() const;
};

/** A robot and its map. */
struct Robot {
  std::string name;
  LoadedMap map;
  mrpt::poses::CPose3DPDFGaussian pose = mrpt::fusion::noGuess();  ///< See mrpt::fusion::RobotMap
  std::shared_ptr<const mrpt::obs::CObservationLocalMap> sent;  ///< Its entry in a mission, if any
};

/** How to build a map from a recording, see mrpt::fusion::BuildParams. */
struct MapDefinition {
  const mrpt::config::CConfigFileBase* config = nullptr;  ///< Null: default map. Not owned
  std::string section;                                    ///< Section of config
  std::function<void(size_t inserted)> progress;  ///< Called with the number of observations
};

/** A map that was built from a recording. */
struct BuiltMap {
  LoadedMap map;                                ///< Without octree if the map is of another kind
  mrpt::fusion::ObservationCount observations;  ///< Observations with and without effect
};

/** What a file holds. */
struct FileContents {
  std::vector<Robot> robots;     ///< Robots of a mission
  std::optional<LoadedMap> map;  ///< Map of another file
};

/** A simplemap with a pose, see mrpt::fusion::PlacedSimpleMap. */
struct PlacedRecording {
  std::string path;
  mrpt::poses::CPose3DPDFGaussian pose;
};

/** A fusion to draw, see mrpt::fusion::FusionView. Nothing is owned. */
struct SceneContents {
  const octomap::OcTree& a;
  const octomap::OcTree& b;
  mrpt::poses::CPose3D pose;  ///< T_a_b
  const mrpt::fusion::Pairs& pairs;
  const mrpt::fusion::EdgeVoxels& edges_a;
  const mrpt::fusion::EdgeVoxels& edges_b;
  double inlier_mahalanobis;
  const octomap::OcTree* fused;
};

/** Appends what changes in the maps of a team to a rawlog. */
class MissionRecorder {
 public:
  virtual ~MissionRecorder() = default;
  /** Appends a diff. \exception std::runtime_error "<path>: <reason>" as of a full disk. */
  virtual void append(const mrpt::fusion::MapDiff& diff) = 0;
};

/** All functions that need MRPT's map classes. They throw std::exceptions. If a file is the reason,
 * the message is "<path>: <reason>". */
class MrptMaps {
 public:
  virtual ~MrptMaps() = default;

  /** Loads a map from a file that is not an octree file. */
  virtual LoadedMap load(const std::string& path, const MapDefinition& definition) const = 0;
  /** Loads the latest map of each robot of a recorded mission, or the map of another file. */
  virtual FileContents loadContents(const std::string& path,
                                    const MapDefinition& definition) const = 0;
  /** Writes a mission. \param[in] smallest See CObservationLocalMap::smallest. */
  virtual void saveMission(const std::vector<Robot>& robots, bool smallest,
                           const std::string& path) const = 0;
  /** Continues a rawlog, or begins it. \exception std::runtime_error "<path>: <reason>" if the
   * file is no mission, or if its end is damaged. */
  virtual std::unique_ptr<MissionRecorder> recordMission(const std::string& path) const = 0;
  /** Builds a map from a recording. */
  virtual BuiltMap build(const std::string& recording, const MapDefinition& definition) const = 0;
  /** Writes the key frames of several simplemaps to one, see mrpt::fusion::joinSimpleMaps().
   * \return Number of key frames. */
  virtual size_t joinRecordings(const std::vector<PlacedRecording>& recordings,
                                const std::string& path) const = 0;
  /** Saves a map, see mrpt::fusion::saveMap(). */
  virtual void save(const LoadedMap& map, const std::string& path) const = 0;
  /** Saves a slice as a mrpt::maps::COccupancyGridMap2D, compressed if the path ends in `.gz`. The
   * cells hold probabilities, unknown cells 0.5. */
  virtual void saveSlice(const mrpt::fusion::MapSlice& slice, const std::string& path) const = 0;
  /** Writes a scene, see mrpt::fusion::drawFusion(). */
  virtual void drawScene(const SceneContents& contents, const std::string& path) const = 0;
  /** Returns poses as a `.graph` file of MRPT: VERTEX3, FIX, EDGE3. */
  virtual std::string toGraphText(const mrpt::fusion::PoseGraph& graph) const = 0;
  /** Removes the temporary files of the module. For signal handlers. */
  virtual void removeTemporaryFiles() const noexcept = 0;
};

/** Returns the functions of the module. Loads the module at the first call.
 * \exception std::runtime_error If the module cannot be loaded. */
const MrptMaps& mrptMaps();

/** Returns the functions of the module if it is loaded, otherwise null. For signal handlers. */
const MrptMaps* loadedMrptMaps() noexcept;

}  // namespace map_fusion
