// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstdint>
#include <memory>
#include <string>
#include <tuple>

/** \file
 * A source: the map of one robot as it came, with its identity. */

namespace mrpt::fusion {

/** Name of a source. Sources are ordered by name: first by robot, then by map. */
struct SourceName {
  std::string robot;  ///< Name of the robot
  std::string map;    ///< Name of the map among the maps of the robot; may be empty

  bool operator==(const SourceName& o) const { return robot == o.robot && map == o.map; }
  bool operator<(const SourceName& o) const {
    return std::tie(robot, map) < std::tie(o.robot, o.map);
  }
};

/** Returns a hash of the resolution and of the log-odds of all voxels of an octree.
 *
 * Octrees with the same voxels have the same hash, pruned or not. Inner nodes and the sensor model
 * do not count. The hash is the same on all machines and in all versions. It is not cryptographic.
 * Cost: one traversal. */
uint64_t voxelHash(const octomap::OcTree& map);

/** One version of the map of one robot. An immutable value: copies share the octree. */
class Source {
 public:
  /** Computes the hash of the map.
   * \param[in] name Name of the source.
   * \param[in] sequence Number of the version. A newer version has a higher number.
   * \param[in] map The map. It is shared and must not change afterwards.
   * \exception std::invalid_argument If the map is null. */
  Source(SourceName name, uint64_t sequence, std::shared_ptr<const octomap::OcTree> map);

  /** Returns the name. */
  const SourceName& name() const { return name_; }
  /** Returns the number of the version. */
  uint64_t sequence() const { return sequence_; }
  /** Returns the map, never null. */
  const std::shared_ptr<const octomap::OcTree>& map() const { return map_; }
  /** Returns voxelHash() of the map. */
  uint64_t contentHash() const { return content_hash_; }

 private:
  SourceName name_;
  uint64_t sequence_;
  std::shared_ptr<const octomap::OcTree> map_;
  uint64_t content_hash_;
};

}  // namespace mrpt::fusion
