// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <octomap/OcTree.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

/** \file
 * The occupied voxels of a map: the paper's input. */

namespace mrpt::fusion {

/** Most voxels that a map is expanded to: a tiny hostile file can hold one leaf that stands for
 * 2^48 of them. */
constexpr size_t kMaxVoxels = 100'000'000;

/** The occupied voxels of a map at its finest resolution: the paper's tuples (centre, size,
 * probability), as parallel arrays in the order of the octree's leaves, as if none were pruned: the
 * voxels of each cube of the tree follow each other. */
struct OccupiedVoxels {
  double resolution = 0;                ///< voxel size d_m, metres
  std::vector<Eigen::Vector3f> centre;  ///< metres, in the map's frame
  std::vector<float> probability;       ///< of being occupied, (0,1)
  std::vector<octomap::OcTreeKey> key;  ///< finest-level octree key of each

  size_t size() const { return centre.size(); }  ///< number of voxels
};

/** Extracts the occupied voxels (probability at least the tree's occupancy threshold), pruned
 * leaves expanded. One traversal, O(nodes + voxels). \param[in] map An octree. \param[in]
 * max_voxels Most voxels to expand to. \exception std::length_error If there are more. */
MRPT_FUSION_API OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map,
                                                     size_t max_voxels = kMaxVoxels);

}  // namespace mrpt::fusion
