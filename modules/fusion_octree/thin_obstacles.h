// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Geometry>

#include "fusion_octree/block_tree.h"
#include "fusion_octree/cube_list.h"
#include "fusion_octree/work_budget.h"

/** \file
 * Obstacles that fall between the centres of a new grid. */

namespace mrpt::fusion {

/** Adds lost obstacles to a resampled map. An occupied source voxel is lost if no voxel of the new
 * grid within half a voxel diagonal is occupied. The new voxel at its centre then gets its value.
 * \param[in] source,blocks The source, as an octree and as arrays.
 * \param[in] T_dst_src Pose of the source's frame in the new frame.
 * \param[in] resolution Voxel size of the new grid, m.
 * \param[in] budget Bound of the voxels that are looked at.
 * \param[in,out] cubes The resampled map. */
void keepThinObstacles(const octomap::OcTree& source, const BlockTree& blocks,
                       const Eigen::Isometry3d& T_dst_src, double resolution,
                       const WorkBudget& budget, CubeList& cubes);

}  // namespace mrpt::fusion
