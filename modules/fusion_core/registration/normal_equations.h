// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>

#include <Eigen/Geometry>
#include <cstddef>

/** \file
 * Linearisation of the error of the pairs, and the scatter of its gradients. */

namespace mrpt::fusion {

/** Normal equations of one linearisation: sum of e' W e = error - 2 g' xi + xi' H xi. */
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();                     ///< Hessian
  Vector6d g = Vector6d::Zero();                     ///< Right-hand side of H xi = g
  double error = 0;                                  ///< Sum of squared Mahalanobis distances
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Centre c of the rotation, m

  /** Returns the equations for steps about another centre, m. */
  NormalEquations about(const Eigen::Vector3d& other) const;
};

/** Scatter of the gradients of patches. A patch is a cube of B. Errors of maps affect a whole piece
 * of wall (drift, a door ajar): the pairs of a patch are dependent, patches nearly independent. */
struct GradientScatter {
  Matrix6d S = Matrix6d::Zero();  ///< Sum of g g' over the patches, about the centre of H
  size_t patches = 0;             ///< Number of patches
};

/** Normal equations of a similarity: translation, rotation, relative growth of B. They hold the
 * scatter of the gradients, too. */
struct SimilarityEquations {
  using Matrix7d = Eigen::Matrix<double, 7, 7>;
  using Vector7d = Eigen::Matrix<double, 7, 1>;
  Matrix7d H = Matrix7d::Zero();                     ///< Hessian
  Vector7d g = Vector7d::Zero();                     ///< Right-hand side of H xi = g
  Matrix7d S = Matrix7d::Zero();                     ///< Sum of g g' over the patches
  size_t patches = 0;                                ///< Number of patches
  double error = 0;                                  ///< Sum of squared Mahalanobis distances
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Fixed point of rotation and growth, m
};

/** Least eigenvalue of H that is information and not rounding, as a share of the largest. */
constexpr double kNoInformation = 1e-10;

/** Returns the matrix [v]x: skew(v) w = v x w. */
inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/** Returns the matrix that converts a step about centre \a from to the equal step about \a to. */
Matrix6d stepAbout(const Eigen::Vector3d& to, const Eigen::Vector3d& from);

}  // namespace mrpt::fusion
