// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/voxels.h>

#include <Eigen/Core>
#include <vector>

#include "fusion_core/map/voxel_blocks.h"

/** \file
 * Algorithm 1, lines 2-6: the surface in each voxel. */

namespace mrpt::fusion {

/** The plane through the voxels around a voxel. */
struct Plane {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit vector; zero: no plane
  float variation = 0;                               // surface variation, [0, 1/3]
  float height = 0;  // height of the plane above the voxel's centre along the normal, voxels
};
/** Returns the plane through the occupied voxels in the \a ball around a voxel. */
Plane surfaceAround(const VoxelBlocks& occupied, const VoxelBlocks::Ball& ball,
                    const octomap::OcTreeKey& key, const EdgeParams& params);

/** Surfaces in the voxels of a map, one per voxel. */
struct Surfaces {
  /** Unit normal of arbitrary sign: the least principal component of the occupied voxels within
   * r_N. Zero if these are fewer than 3, lie on a line, or have no plane. */
  std::vector<Eigen::Vector3f> normal;
  /** Point of the surface in the voxel, m (not in the paper): the voxel's centre moved along the
   * normal onto the plane. The centre itself without a normal. */
  std::vector<Eigen::Vector3f> point;
  /** Surface variation lambda_3 / (lambda_1 + lambda_2 + lambda_3), [0, 1/3]; 0 without a normal.
   */
  std::vector<float> variation;
  /** Number of voxels that the voxel represents: 1 without thinning. */
  std::vector<float> weight;
};

/** Computes the surfaces of voxels, lines 2-6. Cost: O(voxels * neighbours).
 * \param[in] voxels The voxels.
 * \param[in] occupied Index of all occupied voxels of the map, used as neighbours.
 * \param[in] params Radii and limits. */
Surfaces computeSurfaces(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                         const EdgeParams& params);
/** \overload
 * Computes the surfaces of all voxels of a map. */
Surfaces computeSurfaces(const OccupiedVoxels& voxels, const EdgeParams& params);

/** Voxels with their surfaces. */
struct SurfaceVoxels {
  OccupiedVoxels voxels;  ///< Voxels, m, map frame
  Surfaces surfaces;      ///< Surface of each voxel
};

}  // namespace mrpt::fusion
