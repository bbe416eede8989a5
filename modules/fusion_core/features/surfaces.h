// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/voxels.h>

#include <Eigen/Core>
#include <vector>

#include "fusion_core/map/voxel_blocks.h"

/** \file
 * Algorithm 1, lines 2-6: the piece of surface that each voxel is. */

namespace mrpt::fusion {

/** The plane through the voxels around one. */
struct Plane {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit vector, or zero: there is none
  float variation = 0;
  float height = 0;  // above the voxel along the normal, voxels
};
/** Plane through the occupied voxels around a voxel. \param[in] ball Which ones. */
Plane surfaceAround(const VoxelBlocks& occupied, const VoxelBlocks::Ball& ball,
                    const octomap::OcTreeKey& key, const EdgeParams& params);

/** The pieces of surface that a map's voxels are, one per voxel. */
struct Surfaces {
  /** Unit normal, of arbitrary sign: the least principal component of the occupied voxels within
   * r_N. Fewer than three of them, all on a line, or no plane among them: a zero vector. */
  std::vector<Eigen::Vector3f> normal;
  /** The voxel's centre moved along its normal onto the plane through those voxels (not in the
   * paper): where the surface is within the voxel, m. The centre itself if there is no normal. */
  std::vector<Eigen::Vector3f> point;
  /** Surface variation lambda_3 / (lambda_1 + lambda_2 + lambda_3), [0, 1/3]; 0 without a normal.
   */
  std::vector<float> variation;
  /** Of how many voxels each speaks: 1, unless it was chosen to stand for those around it. */
  std::vector<float> weight;
};

/** Lines 2-6. \param[in] voxels Those to tell of. \param[in] occupied All of the map's, their
 * neighbours. \param[in] params Radii. O(voxels * neighbours). */
Surfaces computeSurfaces(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                         const EdgeParams& params);
/** \overload
 * For all of a map's voxels. */
Surfaces computeSurfaces(const OccupiedVoxels& voxels, const EdgeParams& params);

/** Pieces of surface: voxels, and what computeSurfaces() says of each. */
struct SurfaceVoxels {
  OccupiedVoxels voxels;  ///< m, map frame
  Surfaces surfaces;      ///< one for each
};

}  // namespace mrpt::fusion
