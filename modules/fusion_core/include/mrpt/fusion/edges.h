// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/voxels.h>

#include <Eigen/Core>
#include <vector>

#include "fusion_core/features/uncertainty.h"
#include "fusion_core/map/voxel_blocks.h"

/** \file
 * The paper's Algorithm 1: structural edge voxels. */

namespace mrpt::fusion {

/** Settings of Algorithm 1. The paper gives kappa, d_T and the angle window; the rest is ours.
 * Lengths are shortened to 64 voxels, normal_radius to 20: by their cube grows what a voxel costs.
 */
struct EdgeParams {
  double normal_radius = 0.25;  ///< r_N for the normals' PCA, lines 2-6, m
  double cost_radius = 0.60;    ///< r_N for the angle cost, eq. (5), m
  /** Least normal_radius in voxels, so that coarse maps have neighbours too. */
  double min_normal_radius_voxels = 2.5;
  double min_cost_radius_voxels = 6.0;  ///< least cost_radius in voxels
  /** Largest surface variation lambda_3 / (lambda_1 + lambda_2 + lambda_3) of a voxel that has a
   * normal: near 0 on a plane, 0.09 on a clean right-angled edge, 1/3 inside a solid. */
  double max_surface_variation = 0.2;
  /** Least surface variation of a candidate (not in the paper): where the surface is flatter than
   * this it has no edge, and its angle cost need not be known. */
  double min_surface_variation = 0.045;
  double kappa = 0.5;                            ///< least mean angle cost of a candidate (Table I)
  double trace_distance = 0.5;                   ///< d_T, m
  double trace_step_angle = 0.2617993877991494;  ///< delta, rad (15 deg)
  /** Walks leave across the edge that the normals around a voxel suggest, up to this far to either
   * side of that direction, and along it; rad (30 deg). The paper: in all directions, 90 deg. */
  double trace_window = 0.5235987755982988;
  double alpha_min = 1.3962634015954636;  ///< angle window of the two traces, rad (80 deg)
  double alpha_max = 1.7453292519943295;  ///< rad (100 deg)
  unsigned outlier_neighbours = 8;  ///< neighbours whose mean distance tells an outlier (line 23)
  double outlier_deviations = 1.0;  ///< kept up to this many standard deviations above the mean
  double direction_radius = 0.5;    ///< of the edge voxels that make Sigma_tau, eq. (6), m
};

/** The edge voxels of a map, as parallel arrays. */
struct EdgeVoxels {
  double resolution = 0;                   ///< voxel size, m
  double direction_radius = 0;             ///< of the neighbours that make Sigma_tau, m
  std::vector<Eigen::Vector3f> centre;     ///< m, map frame
  std::vector<float> probability;          ///< of being occupied
  std::vector<EdgeCovariance> covariance;  ///< Sigma_tau, eq. (6), from neighbouring edge voxels

  size_t size() const { return centre.size(); }  ///< number of voxels
};

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

/** Eq. (5) for each voxel: the mean |n_j x n_i| over its neighbours, in [0,1]. */
std::vector<float> computeAngleCosts(const OccupiedVoxels& voxels,
                                     const std::vector<Eigen::Vector3f>& normals,
                                     const EdgeParams& params);

/** Pieces of surface: voxels, and what computeSurfaces() says of each. */
struct SurfaceVoxels {
  OccupiedVoxels voxels;  ///< m, map frame
  Surfaces surfaces;      ///< one for each
};

/** All of Algorithm 1, and eq. (6) for what it finds.
 * Deterministic, whatever the number of threads.
 * \param[in] voxels All of the map's. \param[in] occupied The same, to walk on.
 * \param[in] pieces Some of them, spread evenly, whose normals eq. (5) compares: each stands for as
 * many of the voxels as its weight says, which follow each other.
 * \param[in] candidates Indices of the pieces to look in: of the voxels that one stands for at most
 * one is an edge, the one where the surface bends most. \param[in] params All of it. */
EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                        const SurfaceVoxels& pieces, const std::vector<uint32_t>& candidates,
                        const EdgeParams& params);
/** \overload
 * For all of a map's voxels. */
EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const EdgeParams& params);

/** Eq. (6) for edge voxels that are known: each one's covariance from those around it.
 * O(edges * neighbours).
 * \param[in] at Their finest-level octree keys, distinct. \param[in] probability Of each.
 * \param[in] grid An octree of their resolution. \param[in] direction_radius How far around, m; at
 * least 3 and at most 64 voxels are kept to. */
EdgeVoxels edgeVoxelsAt(const std::vector<octomap::OcTreeKey>& at, std::vector<float> probability,
                        const octomap::OcTree& grid, double direction_radius);

}  // namespace mrpt::fusion
