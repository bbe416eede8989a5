// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>

#include <Eigen/Core>
#include <vector>

/** \file
 * The paper's Sec. III: covariances of voxels and structural edges. */

namespace mrpt::fusion {

/** Eq. (4): returns the variance of a voxel's position along each axis, m^2.
 * \param[in] probability Probability of being occupied, (0,1].
 * \param[in] resolution Voxel size, m.
 * \param[in] kind Unit of the variance. */
double voxelVariance(double probability, double resolution, VoxelCovariance kind);

/** Returns the covariance of neighbouring edge voxels, m. Fewer than 3 points, or points at the
 * same place, have no direction: the eigenvalues are then equal, and linearity() is 1/3. Cost:
 * O(points). */
EdgeCovariance edgeCovariance(const std::vector<Eigen::Vector3f>& neighbours);
/** \overload
 * Decomposes the covariance (m^2) of \a neighbours edge voxels. */
EdgeCovariance edgeCovariance(const Eigen::Matrix3d& covariance, size_t neighbours);

/** Eqs. (7)-(9): returns the covariance (Sigma_p^-1 + Sigma_tau^-1)^-1 of the product of the
 * Gaussians of voxel and edge about their common mean.
 * \param[in] voxel_variance Sigma_p = voxel_variance * I, m^2, positive.
 * \param[in] edge Sigma_tau, m^2, symmetric and positive semi-definite. If it is singular, its
 * Gaussian has no extent along an axis, and the product has no extent along that axis either. */
Eigen::Matrix3d fuseCovariances(double voxel_variance, const Eigen::Matrix3d& edge);

}  // namespace mrpt::fusion
