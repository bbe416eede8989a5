// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <octomap/OcTree.h>

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

/** \file
 * The occupied voxels of a map: the paper's input. The known space of a map as cubes. Counts and
 * entropies of the voxels. */

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

/** Parts of the known space of a map. */
enum class KnownSpace {
  Occupied,  ///< Probability at least the octree's occupancy threshold
  Free,      ///< Probability below the threshold
  All        ///< Occupied and free space
};

/** Known space of a map as cubes that do not overlap, as parallel arrays. A cube is a leaf of an
 * octree: its size is the resolution times a power of 2. */
struct Cubes {
  double resolution = 0;                ///< Voxel size, m
  std::vector<Eigen::Vector3f> centre;  ///< Centres, m, map frame
  std::vector<float> log_odds;          ///< Log-odds
  std::vector<float> size;              ///< Lengths of the sides, m

  size_t count() const { return centre.size(); }  ///< Number of cubes
};

/** Returns the leaves of a map, in the order of the octree. The result does not depend on the
 * number of threads. Cost: one traversal, in parallel.
 * \param[in] map An octree.
 * \param[in] part Part of the known space. */
MRPT_FUSION_API Cubes cubesOf(const octomap::OcTree& map, KnownSpace part = KnownSpace::All);

/** Inverts cubesOf(). Log-odds are kept bit for bit, without clamping. Equal siblings are pruned.
 * The sensor model is that of a new octomap::OcTree. Cost: O(n log n).
 * \param[in] cubes Cubes in any order. A cube is the cube of the octree that holds its centre. No
 * sizes: all cubes are voxels.
 * \exception std::invalid_argument If the arrays have different sizes, a number is not finite, a
 * size is not the resolution times a power of 2 from 1 to 65536, a cube is outside the grid of an
 * octree (32768 voxels from the origin), or cubes overlap. The message names the first cube.
 * \exception std::runtime_error If the resolution is not in [1e-4, 1e6] m. */
MRPT_FUSION_API std::unique_ptr<octomap::OcTree> octreeOf(const Cubes& cubes);

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
