// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/voxels.h>
#include <octomap/OcTree.h>

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "fusion_core/map/free_space.h"
#include "fusion_core/map/voxel_blocks.h"

/** \file
 * A map as the stages use it: its octree, its voxels by place, its free space. */

namespace mrpt::fusion {

/** As the public function. In the same traversal, \param[out] free what is free: an empty one at
 * first. \param[in] map An octree. \param[in] max_voxels Most voxels to expand to. */
OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map, FreeSpace& free,
                                     size_t max_voxels = kMaxVoxels);

/** A map, and its voxels. */
struct MapVoxels {
  MapVoxels() = default;
  /** Extracts the voxels. \param[in] of Shared; must not change afterwards. */
  explicit MapVoxels(std::shared_ptr<const octomap::OcTree> of)
      : map(std::move(of)), voxels(extractOccupiedVoxels(*map, free)), occupied(voxels.key) {}

  std::shared_ptr<const octomap::OcTree> map;  ///< the octree
  FreeSpace free;                              ///< all free voxels
  OccupiedVoxels voxels;                       ///< all occupied ones
  VoxelBlocks occupied;                        ///< the same, by their place
};

/** The middle of some points, m; the origin if there are none. */
Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3f>& points);

/** To take \a enough of so many voxels, or a few less, spread evenly over them (0: all), take every
 * so many-th. */
size_t strideFor(size_t voxels, size_t enough);

}  // namespace mrpt::fusion
