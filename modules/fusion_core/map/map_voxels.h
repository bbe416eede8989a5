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
 * A map as the stages use it: octree, occupied voxels, free space. */

namespace mrpt::fusion {

/** Extracts occupied voxels as the public function, and free space in the same traversal.
 * \param[in] map An octree.
 * \param[in,out] free Receives the free space. Empty at first.
 * \param[in] max_voxels Largest number of voxels. */
OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map, FreeSpace& free,
                                     size_t max_voxels = kMaxVoxels);

/** A map and its voxels. */
struct MapVoxels {
  MapVoxels() = default;
  /** Extracts the voxels.
   * \param[in] of The map. It is shared and must not change afterwards. */
  explicit MapVoxels(std::shared_ptr<const octomap::OcTree> of)
      : map(std::move(of)),
        voxels(extractOccupiedVoxels(*map, free)),
        occupied(voxels.key),
        has_free_space(static_cast<double>(free.size()) >=
                       kLeastFreeShare * static_cast<double>(voxels.size())) {}

  std::shared_ptr<const octomap::OcTree> map;  ///< Octree
  FreeSpace free;                              ///< Free voxels
  OccupiedVoxels voxels;                       ///< Occupied voxels
  VoxelBlocks occupied;                        ///< Index of the occupied voxels by place
  /** False if the map has almost no free voxels, for example if it was made of a point cloud. The
   * absence of an obstacle then shows nothing. */
  bool has_free_space = false;

 private:
  static constexpr double kLeastFreeShare = 0.1;  // of the number of occupied voxels
};

/** Returns the mean of points, m; the origin without points. */
Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3f>& points);

/** Returns the stride that selects about \a enough of \a voxels evenly, never more. 0 in \a enough
 * selects all voxels. */
size_t strideFor(size_t voxels, size_t enough);

}  // namespace mrpt::fusion
