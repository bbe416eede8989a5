// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <vector>

#include "fusion_report/page/cubes.h"

/** \file
 * The places where a map contradicts other maps. */

namespace mrpt::fusion {

/** Another map, and where this map lies in it. */
struct OtherMap {
  const octomap::OcTree* map;      ///< The other map; not owned
  Eigen::Isometry3d T_other_this;  ///< Pose of this map in the frame of the other map
};

/** Returns the occupied voxels of a map that lie in the free space of another map, with no occupied
 * voxel of that map around them: what the verdict counts as conflicts. A leaf of more than 64
 * voxels is compared at 64 places. Cost: O(voxels * others). */
PageCubes conflictingCubes(const octomap::OcTree& map, const std::vector<OtherMap>& others);

}  // namespace mrpt::fusion
