// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>

#include "fusion_core/map/map_voxels.h"

/** \file
 * Compares an obstacle at a point with a map. */

namespace mrpt::fusion {

/** Result of the comparison of an obstacle with a map. */
enum class ObstacleCheck : uint8_t {
  Unknown,      ///< The place is unknown, without an obstacle in the voxels around it
  Confirmed,    ///< The map has an obstacle there or in a neighbouring voxel
  Conflicting,  ///< The place is free, without an obstacle in the voxels around it
  Missed        ///< As Unknown, in a map without free space: an obstacle is at most 4 voxels away
};

/** Compares an obstacle at a point (m, map frame) with a map. Only free space without an occupied
 * voxel around it is a conflict: the quantisation of both maps by half a voxel must not cause
 * conflicts. A map without free space (MapVoxels::has_free_space) shows no conflicts. In such a
 * map, a missed obstacle is the evidence against a pose: the map covers the place and shows its
 * obstacles beside it. */
ObstacleCheck checkObstacle(const MapVoxels& map, const Eigen::Vector3d& p);

/** True if a free voxel at a point (m, map frame) has, along an axis, free space on one side only.
 * If there are no obstacles around it, the other side is unknown: the border of the free space. */
bool isAtBorder(const MapVoxels& map, const Eigen::Vector3d& p);

/** True if a map has seen free space at a point, m, map frame. */
bool isFree(const MapVoxels& map, const Eigen::Vector3d& p);

/** True if a map has an obstacle in a ball around a point, m, map frame. */
bool hasObstacle(const MapVoxels& map, const Eigen::Vector3d& p, const VoxelBlocks::Ball& ball);

}  // namespace mrpt::fusion
