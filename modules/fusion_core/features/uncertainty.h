// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>

#include <Eigen/Core>
#include <vector>

/** \file
 * The paper's Sec. III: how uncertain a voxel and a structural edge are. */

namespace mrpt::fusion {

/** Eq. (4): the variance, the same along each axis, of a voxel's position, m^2. \param[in] kind Its
 * unit. \param[in] probability Of being occupied, (0,1]. \param[in] resolution Voxel size, metres.
 */
double voxelVariance(double probability, double resolution, VoxelCovariance kind);

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
