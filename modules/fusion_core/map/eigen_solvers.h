// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

/** \file
 * Decompositions of Eigen that take seconds to compile, compiled once. */

namespace mrpt::fusion {

/** Eigenvalues and eigenvectors of a symmetric matrix, by Eigen::SelfAdjointEigenSolver. */
template <int N>
struct SymmetricEigen {
  Eigen::Matrix<double, N, 1> eigenvalues;   ///< In ascending order
  Eigen::Matrix<double, N, N> eigenvectors;  ///< Unit columns, in the order of the eigenvalues

  /** \param[in] m A symmetric matrix. Only its lower triangle is read. N is 2, 3, 6 or 7. */
  explicit SymmetricEigen(const Eigen::Matrix<double, N, N>& m);
};

/** Returns the smallest rotation that turns one direction to another, by Eigen::Quaterniond. */
Eigen::Matrix3d rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace mrpt::fusion
