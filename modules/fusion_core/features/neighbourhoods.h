// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>

#include <algorithm>

#include "fusion_core/map/voxel_blocks.h"

/** \file
 * Neighbourhoods of the steps of Algorithm 1. */

namespace mrpt::fusion {

/** Largest radius, voxels. Maps of buildings need no larger radius. Memory and time of a
 * neighbourhood grow with the cube of the radius. */
constexpr double kMostVoxels = 64;

inline double radiusInVoxels(double radius, double least, double resolution) {
  return resolution > 0 ? std::clamp(radius / resolution, least, kMostVoxels) : least;
}

inline VoxelBlocks::Ball normalBall(const EdgeParams& params, double resolution) {
  constexpr double kMostExact = 20;  // see Moments
  return VoxelBlocks::Ball(
      std::min(radiusInVoxels(params.normal_radius, params.min_normal_radius_voxels, resolution),
               kMostExact));
}

inline VoxelBlocks::Ball costBall(const EdgeParams& params, double resolution) {
  return VoxelBlocks::Ball(
      radiusInVoxels(params.cost_radius, params.min_cost_radius_voxels, resolution));
}

inline VoxelBlocks::Place placeOf(const octomap::OcTreeKey& key) {
  return {key[0], key[1], key[2]};
}

}  // namespace mrpt::fusion
