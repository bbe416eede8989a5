// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Moves the covariance of a pose to a point. */

#include "fusion_report/page/covariance.h"

#include <Eigen/Eigenvalues>

namespace mrpt::fusion {

Eigen::Matrix3d covarianceOf(const mrpt::poses::CPose3DPDFGaussian& pose,
                             const Eigen::Vector3d& point) {
  mrpt::math::CMatrixFixed<double, 3, 6> by_pose;
  double x, y, z;
  pose.mean.composePoint(point.x(), point.y(), point.z(), x, y, z, std::nullopt, std::ref(by_pose));
  const Eigen::Matrix<double, 3, 6> J = by_pose.asEigen();
  return J * pose.cov.asEigen() * J.transpose();
}

Eigen::Matrix3d ellipsoidOf(const Eigen::Matrix3d& covariance) {
  constexpr double kDeviations = 3;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  return solver.eigenvectors() *
         (kDeviations * solver.eigenvalues().cwiseMax(0).cwiseSqrt()).asDiagonal();
}

}  // namespace mrpt::fusion
