// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fusion_core/registration/normal_equations.h"

/** \file
 * Covariances of left and right perturbations of a pose. */

namespace mrpt::fusion {

/** Returns the matrix that converts a right perturbation of \a T (translation, rotation; B's frame)
 * to the equal left perturbation (A's frame): T exp(xi) = exp(adjointOf(T) xi) T. */
inline Matrix6d adjointOf(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d R = T.linear();
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = R;
  adjoint.topRightCorner<3, 3>() = skew(T.translation()) * R;
  adjoint.bottomRightCorner<3, 3>() = R;
  return adjoint;
}

/** Converts the covariance of a right perturbation of \a T to the covariance of a left
 * perturbation, see MatchResult::covariance. The result is symmetric to the last bit. */
inline Matrix6d toLeftCovariance(const Matrix6d& covariance, const Eigen::Isometry3d& T) {
  const Matrix6d J = adjointOf(T);
  const Matrix6d result = J * covariance * J.transpose();
  return 0.5 * (result + result.transpose());
}

/** Inverts toLeftCovariance(). */
inline Matrix6d toRightCovariance(const Matrix6d& covariance, const Eigen::Isometry3d& T) {
  return toLeftCovariance(covariance, T.inverse());
}

}  // namespace mrpt::fusion
