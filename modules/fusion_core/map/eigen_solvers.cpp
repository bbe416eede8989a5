// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/map/eigen_solvers.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace mrpt::fusion {

template <int N>
SymmetricEigen<N>::SymmetricEigen(const Eigen::Matrix<double, N, N>& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>> solver(m);
  eigenvalues = solver.eigenvalues();
  eigenvectors = solver.eigenvectors();
}

template struct SymmetricEigen<2>;
template struct SymmetricEigen<3>;
template struct SymmetricEigen<6>;
template struct SymmetricEigen<7>;

Eigen::Matrix3d rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

}  // namespace mrpt::fusion
