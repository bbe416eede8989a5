// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Estimates the directions in which pairs hold a pose, and in which they slide. */
#include "fusion_core/registration/observability.h"

#include <algorithm>
#include <cmath>

#include "fusion_core/map/eigen_solvers.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_core/registration/pose_covariance.h"
#include "fusion_core/registration/solver.h"

namespace mrpt::fusion {

Matrix6d covarianceAt(VoxelLevel& level, const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                      double step, const CovarianceParams& params) {
  NormalEquations equations = level.linearize(pairs, T_a_b);
  const GradientScatter gradients = level.scatter(pairs, T_a_b, equations.centre);
  equations.H = heldHessian(level, equations, pairs, T_a_b, step, params);
  return poseCovariance(equations, pairs.size(), gradients) +
         level.commonCovariance(pairs, equations.centre);
}

Matrix6d heldHessian(LevelProblem& level, const NormalEquations& equations, const Pairs& pairs,
                     const Eigen::Isometry3d& T_a_b, double step, const CovarianceParams& params) {
  const size_t stride = strideFor(pairs.size(), params.sample_pairs);
  Pairs some;
  for (size_t i = 0; i < pairs.size(); i += stride) some.push_back(pairs[i]);
  const NormalEquations at_rest = level.linearize(some, T_a_b);
  const DescriptorWeights w = level.weights(meanSquaredError(some));
  const auto pullAt = [&](const Vector6d& xi) {
    const Eigen::Isometry3d moved = perturb(T_a_b, xi, at_rest.centre);
    return level.linearize(level.associate(moved, w, params.held_gate * step, &some), moved)
        .about(at_rest.centre)
        .g;
  };

  // Rotations are scaled to m, at the RMS distance of the pairs from their centre.
  const double reach2 =
      equations.H.bottomRightCorner<3, 3>().trace() / equations.H.topLeftCorner<3, 3>().trace();
  if (!(reach2 > 0)) return equations.H;
  Vector6d scale = Vector6d::Ones();
  scale.tail<3>() /= std::sqrt(reach2);
  const SymmetricEigen<6> eigen(scale.asDiagonal() * equations.H * scale.asDiagonal());
  Vector6d held = eigen.eigenvalues;
  for (int i = 0; i < 6; i++) {
    const Vector6d xi = step * scale.cwiseProduct(eigen.eigenvectors.col(i));
    const double expected = 2 * xi.dot(at_rest.H * xi);
    const double found = expected > 0 ? xi.dot(pullAt(-xi) - pullAt(xi)) / expected : 0;
    // `found` is at least 0.6 in held directions and below 0.1 along a corridor.
    held[i] *= found < params.min_pull ? 0 : std::min(found, 1.0);
  }
  const Matrix6d V = scale.cwiseInverse().asDiagonal() * eigen.eigenvectors;
  return V * held.asDiagonal() * V.transpose();
}

}  // namespace mrpt::fusion
