// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

/** \file
 * The sources of a map: which maps of which robots are in it. */

namespace mrpt::fusion {

/** Identity of a source: one version of the map of one robot, as it came. */
struct SourceId {
  std::string robot;      ///< Name of the robot; empty if unknown, as for the file of an octree
  std::string map;        ///< Name of the map among the maps of the robot; may be empty
  uint64_t sequence = 0;  ///< Number of the version. The highest is the latest
  /** Hash of the resolution and of the log-odds of all voxels. 0: that of the map that has this
   * source. */
  uint64_t content_hash = 0;

  /** True if all fields are equal. */
  bool operator==(const SourceId& o) const {
    return content_hash == o.content_hash && sequence == o.sequence && robot == o.robot &&
           map == o.map;
  }
};

/** The sources of a map. The map of one robot has one; a fused map has the sources of all its maps.
 * Each source is there once. */
using Sources = std::vector<SourceId>;

/** How the observations of a map count in a fused map. No observation counts twice. */
enum class Counting {
  All,           ///< All observations of the map count
  UnknownSpace,  ///< Another map has some of its sources. The map adds only space that no map knows
                 ///< whose observations all count
  None,          ///< Another map has all of its sources. Nothing is added
  Copy           ///< Another map has the same voxels. Nothing is added
};

}  // namespace mrpt::fusion
