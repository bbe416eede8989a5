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

/** Largest number of voxels of an expanded map. The limit guards against hostile files: a tiny file
 * can hold one leaf of 2^48 finest voxels. */
constexpr size_t kMaxVoxels = 100'000'000;

/** The occupied voxels of a map at its finest resolution: the paper's tuples (centre, size,
 * probability) as parallel arrays. The order is that of the leaves of an octree without pruning:
 * the voxels of each cube of the octree follow each other. */
struct OccupiedVoxels {
  double resolution = 0;                ///< Voxel size d_m, m
  std::vector<Eigen::Vector3f> centre;  ///< Centres, m, map frame
  std::vector<float> probability;       ///< Probabilities of being occupied, (0,1)
  std::vector<octomap::OcTreeKey> key;  ///< Octree keys at the finest depth

  size_t size() const { return centre.size(); }  ///< Number of voxels
};

/** Extracts the occupied voxels: probability at least the octree's occupancy threshold. Pruned
 * leaves are expanded. Cost: one traversal, O(nodes + voxels).
 * \param[in] map An octree.
 * \param[in] max_voxels Largest number of voxels.
 * \exception std::length_error If the map has more occupied voxels than max_voxels. */
MRPT_FUSION_API OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map,
                                                     size_t max_voxels = kMaxVoxels);

}  // namespace mrpt::fusion
