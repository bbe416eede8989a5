// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <octomap/OcTree.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

/** \file
 * The occupied voxels of a map: the paper's input. Counts and entropies of the voxels. */

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
 * \exception std::length_error If the map has more occupied voxels than max_voxels, or more than 4
 * million and 64 per node: a tiny file can hold leaves with billions of voxels. */
MRPT_FUSION_API OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map,
                                                     size_t max_voxels = kMaxVoxels);

/** Settings of the scale of a map: the factor of all lengths in the options. The default lengths
 * fit buildings at voxels of 5 to 20 cm, where the factor is 1. It is larger for larger voxels, and
 * smaller for small scenes at small voxels. The scale of a pair is the larger scale of its maps. */
struct ScaleParams {
  double fixed = 0;           ///< Scale of all maps; 0: computed from the voxels of each map
  double fine_voxel = 0.05;   ///< Voxel size below which the scale may be below 1, m
  double coarse_voxel = 0.2;  ///< Voxel size above which the scale is above 1, m
  double small_scene = 10;    ///< Size of a scene below which the scale may be below 1, m
};

/** Figures of a map's voxels. A pruned leaf counts as all finest voxels in it. */
struct MapStatistics {
  size_t occupied = 0;               ///< Number of occupied finest voxels
  size_t free = 0;                   ///< Number of free finest voxels
  double mean_entropy_occupied = 0;  ///< Mean binaryEntropy() of occupied voxels, nats
  double mean_entropy_known = 0;     ///< Mean over occupied and free voxels, nats
};
/** Counts the voxels of a map. Cost: one traversal. */
MRPT_FUSION_API MapStatistics statisticsOf(const octomap::OcTree& map);

/** Returns the Shannon entropy of an occupancy probability, `-p ln p - (1-p) ln(1-p)`, nats: the
 * measure of the paper's Table V. It is 0 at p = 0 and p = 1. */
MRPT_FUSION_API double binaryEntropy(double p);

}  // namespace mrpt::fusion
