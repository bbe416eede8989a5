// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Computes steps on SE(3). */
#include "fusion_core/registration/solver.h"

#include <cmath>

#include "fusion_core/map/eigen_solvers.h"

namespace mrpt::fusion {

Eigen::Isometry3d expSE3(const Vector6d& xi) {
  const Eigen::Vector3d w = xi.tail<3>();
  const double angle = w.norm();
  const Eigen::Matrix3d W = skew(w);
  double a = 0.5, b = 1.0 / 6;  // (1 - cos)/angle^2 and (angle - sin)/angle^3
  if (angle > 1e-4) {
    a = (1 - std::cos(angle)) / (angle * angle);
    b = (angle - std::sin(angle)) / (angle * angle * angle);
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (angle > 0) T.linear() = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  T.translation() = (Eigen::Matrix3d::Identity() + a * W + b * W * W) * xi.head<3>();
  return T;
}

Eigen::Isometry3d perturb(const Eigen::Isometry3d& T, const Vector6d& xi,
                          const Eigen::Vector3d& centre) {
  return Eigen::Translation3d(centre) * expSE3(xi) * Eigen::Translation3d(-centre) * T;
}

Vector6d solveDamped(const NormalEquations& equations, double lambda) {
  const SymmetricEigen<6> solution(equations.H);
  const auto& values = solution.eigenvalues;  // ascending
  const double least = kNoInformation * values[5];
  int unknown = 0;
  while (unknown < 6 && !(values[unknown] > least)) unknown++;
  if (unknown == 6) return Vector6d::Zero();
  const Eigen::MatrixXd V = solution.eigenvectors.rightCols(6 - unknown);
  Matrix6d H = equations.H;
  H.diagonal() *= 1 + lambda;
  const Eigen::MatrixXd reduced = V.transpose() * H * V;
  return V * reduced.ldlt().solve(V.transpose() * equations.g);
}

}  // namespace mrpt::fusion
