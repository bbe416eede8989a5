// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>

#include <cstddef>

/** \file
 * Settings of registration, which refines a pose in two levels. */

namespace mrpt::fusion {

/** Factors of eqs. (19)-(20). The paper does not give their values. */
struct WeightParams {
  double k1 = 0.1;  ///< Factor of the occupancy distance
  double k2 = 1.0;  ///< Factor of the direction distance
};

/** Settings of one of the two levels. */
struct LevelParams {
  unsigned max_iterations = 30;  ///< Largest number of associations
  double gate = 2.0;  ///< Largest descriptor distance of a pair at the first iteration, m
  /** Final gate, m. The gate is multiplied by RegistrationParams::gate_shrink after each iteration
   * whose step is below RegistrationParams::settled_step times the gate, down to this value. The
   * paper keeps the gate constant: set final_gate = gate. */
  double final_gate = 2.0;
};

/** Distance that the voxel level minimises. */
enum class VoxelMetric {
  Point,   ///< Distance of the voxels, eq. (22), as published
  Surface  ///< Distance of the surfaces in the voxels
};

/** Settings of the Levenberg-Marquardt solver. */
struct SolverParams {
  unsigned max_steps = 10;        ///< Largest number of steps for one set of pairs
  double min_translation = 1e-5;  ///< Least step, translation, m
  double min_rotation = 1e-5;     ///< Least step, rotation, rad
};

/** Settings of a pose's covariance. */
struct CovarianceParams {
  double held_gate = 3;       ///< Gate of the pairs of a moved pose, voxels
  size_t sample_pairs = 600;  ///< Number of pairs in the test for sliding
  double min_pull = 0.1;      ///< Least pull over expected pull of a held direction, [0,1]
  double patch_size = 6;      ///< Side of the cubes whose pairs are not independent, m
  double common_share =
      1. / 3;  ///< Share of the quantisation variance that all pairs have in common
};

/** Settings of registration. */
struct RegistrationParams {
  WeightParams weights;  ///< Weights of the descriptors
  /** Unit of eq. (4) at the edge level. */
  VoxelCovariance voxel_covariance = VoxelCovariance::Plain;
  LevelParams edge_level{30, 2.0, 0.8};   ///< Settings of the edge level; gate: Table I
  LevelParams voxel_level{30, 0.5, 0.2};  ///< Settings of the voxel level; gate: Table I
  double min_voxel_gate = 2;              ///< Least gate of voxel pairs, in voxels
  double gate_shrink = 0.8;               ///< Factor of the gate after a settled iteration
  double settled_step = 0.05;             ///< Largest step of a settled iteration over the gate
  VoxelMetric voxel_metric = VoxelMetric::Surface;  ///< Distance that the voxel level minimises
  double flatness = 0.01;  ///< Variance across over variance along a surface
  /** Settings of the solver. One step for each set of pairs: the next association changes the pairs
   * more than a second step would change the pose. */
  SolverParams solver{1, 1e-5, 1e-5};
  size_t first_pairs = 4000;           ///< Number of voxels for the first MSE
  double min_step_translation = 1e-3;  ///< Least step of an iteration, translation, m
  double min_step_rotation = 1e-4;     ///< Least step of an iteration, rotation, rad
  CovarianceParams covariance;         ///< Settings of the covariance of the result
};

}  // namespace mrpt::fusion
