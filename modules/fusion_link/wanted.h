// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <vector>

#include "fusion_link/map_index.h"

/** \file
 * Which blocks of another robot's map are worth most. */

namespace mrpt::fusion {

/** Returns the blocks of a map that overlap with the map of this robot, the block with the most
 * overlap first.
 * \param[in] index Index of the other map.
 * \param[in] outline Outline of the other map, in its frame.
 * \param[in] own Map of this robot.
 * \param[in] T_own_other Pose of the other map's frame in the frame of \a own.
 * Cost: O(leaves of the outline). */
std::vector<BlockCode> blocksOfOverlap(const MapIndex& index, const octomap::OcTree& outline,
                                       const octomap::OcTree& own,
                                       const Eigen::Isometry3d& T_own_other);

}  // namespace mrpt::fusion
