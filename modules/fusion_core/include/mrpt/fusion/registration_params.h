// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>

#include <cstddef>

/** \file
 * Settings of registration: the two levels that refine a pose. */

namespace mrpt::fusion {

/** The factors of eqs. (19)-(20), not given in the paper. */
struct WeightParams {
  double k1 = 0.1;  ///< Factor of the occupancy distance
  double k2 = 1.0;  ///< Factor of the direction distance
};

/** Settings of one of the two levels. */
struct LevelParams {
  unsigned max_iterations = 30;  ///< Most associations
  double gate = 2.0;  ///< Largest descriptor distance of a pair at the first iteration, m
  /** Final gate, m. The gate is multiplied by RegistrationParams::gate_shrink after each iteration
   * whose step is below RegistrationParams::settled_step times the gate, down to this value. The
   * paper keeps the gate constant: set final_gate = gate. */
  double final_gate = 2.0;
};

/** What the voxel level minimises. */
enum class VoxelMetric {
  Point,   ///< Distance between voxels: eq. (22), as published
  Surface  ///< Distance between the surfaces that the voxels are pieces of
};

/** Settings of the Levenberg-Marquardt solver. */
struct SolverParams {
  unsigned max_steps = 10;        ///< Most steps for one set of pairs
  double min_translation = 1e-5;  ///< Stops below this step, m,
  double min_rotation = 1e-5;     ///< and below this step, rad
};

/** Settings of a pose's covariance. */
struct CovarianceParams {
  double held_gate = 3;       ///< Gate of the pairs of a moved pose, in voxels (the step)
  size_t sample_pairs = 600;  ///< Pairs that tell how firmly a pose is held
  double min_pull = 0.1;      ///< Least share of the expected pull that counts as held, [0,1]
  double patch_size = 6;      ///< Side of the cubes whose pairs are taken as dependent, m
  double common_share =
      1. / 3;  ///< Share of the quantisation variance that all pairs have in common
};

/** Settings of registration. */
struct RegistrationParams {
  WeightParams weights;  ///< Weights of the descriptors
  /** Unit of eq. (4) beside eq. (6) at the edge level. */
  VoxelCovariance voxel_covariance = VoxelCovariance::Plain;
  LevelParams edge_level{30, 2.0, 0.8};   ///< Edge level; gate: Table I
  LevelParams voxel_level{30, 0.5, 0.2};  ///< Voxel level; gate: Table I
  double min_voxel_gate = 2;              ///< Least gate of voxel pairs, in voxels
  double gate_shrink = 0.8;               ///< Factor of the gate after an iteration that settled
  double settled_step = 0.05;             ///< Largest step of a settled iteration, times the gate
  VoxelMetric voxel_metric = VoxelMetric::Surface;  ///< What the voxel level minimises
  double flatness = 0.01;  ///< Variance across over variance along a surface voxel
  /** Solver. One step: the pairs change before a second step would tell more. */
  SolverParams solver{1, 1e-5, 1e-5};
  size_t first_pairs = 4000;  ///< Voxels whose nearest neighbours give the first MSE
  /** A level has converged when an iteration moves the pose by less than both. */
  double min_step_translation = 1e-3;  ///< m
  double min_step_rotation = 1e-4;     ///< rad
  CovarianceParams covariance;         ///< Covariance of the result
};

}  // namespace mrpt::fusion
