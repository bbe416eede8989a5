// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/fusion/voxels.h>

#include <Eigen/Core>
#include <vector>

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
  /** Walks beside that direction are tried only where the walks straight across make an angle at
   * most this far outside of the window, rad (20 deg). What is far from a bend straight across is
   * an edge to the side only by chance. */
  double trace_beside = 0.3490658503988659;
  double alpha_min = 1.3962634015954636;  ///< angle window of the two traces, rad (80 deg)
  double alpha_max = 1.7453292519943295;  ///< rad (100 deg)
  unsigned outlier_neighbours = 8;  ///< neighbours whose mean distance tells an outlier (line 23)
  double outlier_deviations = 1.0;  ///< kept up to this many standard deviations above the mean
  double direction_radius = 0.5;    ///< of the edge voxels that make Sigma_tau, eq. (6), m
};

/** In what unit eq. (4)'s p^-1 stands beside eq. (6)'s square metres. */
enum class VoxelCovariance {
  Plain,        ///< as published: p^-1 square metres, whatever the voxel's size
  Quantisation  ///< p^-1 times the variance of a uniform position in the voxel, d_m^2 / 12
};

/** Eq. (6): the spatial covariance of the edge voxels around one, by its eigen-decomposition. */
struct MRPT_FUSION_API EdgeCovariance {
  Eigen::Vector3d eigenvalues = Eigen::Vector3d::Zero();       ///< ascending, m^2
  Eigen::Matrix3d eigenvectors = Eigen::Matrix3d::Identity();  ///< columns, same order

  /** The edge direction tau, a unit vector of arbitrary sign. */
  Eigen::Vector3d direction() const { return eigenvectors.col(2); }
  /** One edge's term of eq. (16): 1 on a perfect line, 1/3 where no direction stands out. */
  double linearity() const;
  /** The covariance with \a floor_variance (m^2) added along each axis: the neighbourhood of a
   * perfect line has no extent across it, but its voxels have. */
  Eigen::Matrix3d matrix(double floor_variance) const;
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

/** All of Algorithm 1, and eq. (6) for the edges that it finds.
 * Deterministic, whatever the number of threads. O(voxels * neighbours).
 * \param[in] voxels All occupied voxels of a map. \param[in] params All of it. */
MRPT_FUSION_API EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const EdgeParams& params);

}  // namespace mrpt::fusion
