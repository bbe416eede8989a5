// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "fusion_core/map/free_space.h"
#include "fusion_core/map/voxel_blocks.h"
#include "fusion_octree/walk.h"

namespace mrpt::fusion {

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
 * max_voxels Refuse to expand to more voxels than this (a tiny hostile file can hold one leaf that
 * stands for 2^48 voxels). \exception std::length_error If there are more.
 */
OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map, size_t max_voxels = kMaxVoxels);
/** \overload
 * In the same traversal, \param[out] free what is free: an empty one at first. */
OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map, FreeSpace& free,
                                     size_t max_voxels = kMaxVoxels);

/** A map, and its voxels. */
struct MapVoxels {
  MapVoxels() = default;
  /** Extracts them. \param[in] of Not owned, must outlive this. */
  explicit MapVoxels(const octomap::OcTree& of)
      : map(&of), voxels(extractOccupiedVoxels(of, free)), occupied(voxels.key) {}

  const octomap::OcTree* map = nullptr;  ///< not owned, must outlive this, and stay as it is
  FreeSpace free;                        ///< all free voxels
  OccupiedVoxels voxels;                 ///< all occupied ones
  VoxelBlocks occupied;                  ///< the same, by their place
};

/** The middle of some points, m; the origin if there are none. */
Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3f>& points);

/** Figures of a map's voxels, each pruned leaf counted as the finest voxels it stands for. */
struct MapStatistics {
  size_t occupied = 0;               ///< finest voxels
  size_t free = 0;                   ///< finest voxels
  double mean_entropy_occupied = 0;  ///< mean of binaryEntropy() over occupied voxels, nats
  double mean_entropy_known = 0;     ///< over occupied and free voxels, nats
};
/** Counts all of a map's voxels. One traversal. */
MapStatistics statisticsOf(const octomap::OcTree& map);

/** Shannon entropy of an occupancy probability, `-p ln p - (1-p) ln(1-p)`, in nats: the measure of
 * the paper's Table V. 0 at p = 0 and p = 1. */
double binaryEntropy(double p);

/** To take \a enough of so many voxels, or a few less, spread evenly over them (0: all), take every
 * so many-th. */
size_t strideFor(size_t voxels, size_t enough);

}  // namespace mrpt::fusion
