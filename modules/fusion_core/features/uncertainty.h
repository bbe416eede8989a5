// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

/** \file
 * The paper's Sec. III: how uncertain a voxel and a structural edge are. */

namespace mrpt::fusion {

/** In what unit eq. (4)'s p^-1 stands beside eq. (6)'s square metres. */
enum class VoxelCovariance {
  Plain,        ///< as published: p^-1 square metres, whatever the voxel's size
  Quantisation  ///< p^-1 times the variance of a uniform position in the voxel, d_m^2 / 12
};

/** Eq. (4): the variance, the same along each axis, of a voxel's position, m^2. \param[in] kind Its
 * unit. \param[in] probability Of being occupied, (0,1]. \param[in] resolution Voxel size, metres.
 */
double voxelVariance(double probability, double resolution, VoxelCovariance kind);

/** Eq. (6): the spatial covariance of the edge voxels around one, by its eigen-decomposition. */
struct EdgeCovariance {
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

/** The covariance of a set of neighbouring edge voxels (metres).
 * Fewer than three points, or all in one place, tell no direction: all eigenvalues come out equal
 * (linearity() is 1/3). O(points). */
EdgeCovariance edgeCovariance(const std::vector<Eigen::Vector3f>& neighbours);
/** \overload
 * For the covariance (m^2) of so many neighbours. */
EdgeCovariance edgeCovariance(const Eigen::Matrix3d& covariance, size_t neighbours);

/** Eqs. (7)-(9): the product of the voxel's and the edge's Gaussians,
 * (Sigma_p^-1 + Sigma_tau^-1)^-1, about their common mean.
 * \param[in] voxel_variance Sigma_p = voxel_variance * I, m^2, positive.
 * \param[in] edge Sigma_tau, m^2, symmetric and positive semi-definite (a singular one is a
 * Gaussian of no extent along some axis, and so is the product). */
Eigen::Matrix3d fuseCovariances(double voxel_variance, const Eigen::Matrix3d& edge);

}  // namespace mrpt::fusion
