// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/sources.h>
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

/** Returns the name of a source for people. */
inline std::string nameOf(const SourceName& source) {
  return source.map.empty() ? source.robot : source.robot + "/" + source.map;
}

/** One version of the map of one robot. An immutable value: copies share the octree. */
class Source {
 public:
  /** Computes the hash of the map.
   * \param[in] name Name of the source.
   * \param[in] sequence Number of the version. A newer version has a higher number.
   * \param[in] map The map. It is shared and must not change afterwards.
   * \param[in] parts Sources of the map, if it is a fused map. Empty: the map is a source of its
   * own, of an unknown robot, so that only a map with the same voxels is the same source. A content
   * hash of 0 becomes that of the map.
   * \exception std::invalid_argument If the map is null. */
  Source(SourceName name, uint64_t sequence, std::shared_ptr<const octomap::OcTree> map,
         Sources parts = {});

  /** Returns the name. */
  const SourceName& name() const { return name_; }
  /** Returns the number of the version. */
  uint64_t sequence() const { return sequence_; }
  /** Returns the map, never null. */
  const std::shared_ptr<const octomap::OcTree>& map() const { return map_; }
  /** Returns voxelHash() of the map. */
  uint64_t contentHash() const { return content_hash_; }
  /** Returns the sources of the map, at least one. */
  const Sources& parts() const { return parts_; }

 private:
  SourceName name_;
  uint64_t sequence_;
  std::shared_ptr<const octomap::OcTree> map_;
  uint64_t content_hash_;
  Sources parts_;
};

}  // namespace mrpt::fusion
