// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/poses.h>
#include <mrpt/fusion/prepared_map.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <octomap/OcTree.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "settings.h"

/** \file
 * Maps in Python. */

namespace mrpt_fusion_python {

/** Where a map comes from. All fields may be empty. */
struct Origin {
  std::string name;               ///< Name of the robot or of the file without extension
  std::string path;               ///< File of the map
  mrpt::fusion::Sources sources;  ///< Sources of a map that knows none
  /** Pose that a robot sent with its map, in a common frame. */
  mrpt::poses::CPose3DPDFGaussian pose = mrpt::fusion::noGuess();
  static Origin of(std::string path);  ///< Origin of the map of a file, as map-fusion names it
};

/** A map, or structural edges alone. An immutable value, but for what it remembers. */
class Map {
 public:
  Map(std::shared_ptr<const mrpt::maps::CProbOctoMap> whole, Origin origin);
  Map(std::shared_ptr<const mrpt::maps::CEdgeVoxelMap> edges, Origin origin);
  /** Makes a map of a map of MRPT.
   * \exception std::runtime_error If it is not, and does not hold, a 3-D occupancy map. */
  static std::shared_ptr<Map> from(const mrpt::maps::CMetricMap::ConstPtr& map, Origin origin);

  bool isEdgesAlone() const { return edges_ != nullptr; }
  /** Returns the map. \exception std::runtime_error If only edges are known. */
  const mrpt::maps::CProbOctoMap& whole() const;
  /** Returns the map as it is saved and sent. */
  const mrpt::maps::CMetricMap& metricMap() const;
  /** Returns the octree; of edges alone, their voxels. */
  const std::shared_ptr<const octomap::OcTree>& octree() const { return octree_; }
  const Origin& origin() const { return origin_; }

  /** Prepares the map for matching. Remembers the result for the last settings. Sources: those of
   * the map, or of its origin. Several threads may call it.
   */
  mrpt::fusion::PreparedMap prepared(const Settings& settings) const;
  /** Returns the sources that prepared() sets. */
  mrpt::fusion::Sources sources() const;

 private:
  std::shared_ptr<const mrpt::maps::CProbOctoMap> whole_;
  std::shared_ptr<const mrpt::maps::CEdgeVoxelMap> edges_;
  std::shared_ptr<const octomap::OcTree> octree_;
  Origin origin_;
  mutable std::mutex mutex_;
  mutable std::string prepared_by_;  // text of settings
  mutable std::optional<mrpt::fusion::PreparedMap> prepared_;
};

using MapPtr = std::shared_ptr<const Map>;

/** Returns the map that an argument of Python is: a Map, or the path of a file. The file is loaded
 * without the GIL. */
MapPtr mapOf(const pybind11::object& map);

/** Returns a new octree as a map with sources. */
MapPtr mapOf(std::unique_ptr<octomap::OcTree> octree, mrpt::fusion::Sources sources);

/** Returns a map as an object of Python. */
pybind11::object toPython(const MapPtr& map);

}  // namespace mrpt_fusion_python
