// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <Eigen/Core>

/** \file
 * The uncertainty of a pose as an ellipsoid. */

namespace mrpt::fusion {

/** Returns the covariance of a point of a map that the pose moves, m^2.
 * \param[in] pose Pose of the map, with its covariance.
 * \param[in] point The point in the frame of the map, m. */
Eigen::Matrix3d covarianceOf(const mrpt::poses::CPose3DPDFGaussian& pose,
                             const Eigen::Vector3d& point);

/** Returns the half-axes of the ellipsoid of 3 standard deviations, as columns, m. */
Eigen::Matrix3d ellipsoidOf(const Eigen::Matrix3d& covariance);

}  // namespace mrpt::fusion
