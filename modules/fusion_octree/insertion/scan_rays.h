// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "fusion_octree/insertion/cell_window.h"

/** \file
 * The rays of a scan as octomap computes them: to the end of each beam, or to the maximal range.
 */

namespace mrpt::fusion {

/** The common origin of the rays of a scan, and the grid. */
struct RayOrigin {
  RayOrigin(const octomap::OcTree& tree, const octomap::point3d& origin);

  octomap::point3d point;  ///< The origin, m
  double resolution = 0;   ///< Voxel size, m
  double factor = 0;       ///< 1 / resolution
  bool in_grid = true;     ///< False if the origin is outside of the octree's grid: no ray is free
  CellKey key{};           ///< Voxel of the origin
  /** Distance from the origin to the border of its voxel by axis, downwards and upwards, m */
  std::array<std::array<double, 2>, 3> to_border{};
};

/** Up to 256 rays of a scan. */
struct RayChunk {
  static constexpr size_t kMost = 256;  ///< Largest number of rays

  size_t size = 0;                        ///< Number of rays
  std::array<float, kMost> x, y, z;       ///< Ends, m
  std::array<int32_t, kMost> kx, ky, kz;  ///< Voxels of the ends. Of ends outside of the grid: any
  /** Number of voxels from the origin to the end, the end included. 0: no voxel becomes free. */
  std::array<uint32_t, kMost> steps;
  std::array<uint8_t, kMost> hit;  ///< 1 if the voxel of the end becomes occupied
  CellBox box;                     ///< Box of the voxels of the ends

  CellKey key(size_t i) const { return {kx[i], ky[i], kz[i]}; }  ///< Voxel of an end
};

/** Fills a chunk with rays. \param[in] ends First end, m. \param[in] count Number of ends, at most
 * RayChunk::kMost. \param[in] origin The origin. \param[in] max_range Length of the longest ray, m.
 * Longer rays become free up to this length, and their ends are not occupied. Negative: no limit.
 * \param[out] chunk The rays. */
void makeRays(const octomap::point3d* ends, size_t count, const RayOrigin& origin, double max_range,
              RayChunk& chunk);

}  // namespace mrpt::fusion
