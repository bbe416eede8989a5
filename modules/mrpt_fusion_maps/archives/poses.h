// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/poses/CPose3DPDFGaussian.h>

/** \file
 * Checks of poses that come from outside. */

namespace mrpt::fusion {

/** Largest coordinate of a pose in a stream, m: the largest that a prior may have. */
constexpr double kMostPoseCoordinate = 1e8;

/** Checks a pose with its covariance.
 * \exception std::exception If a number is not finite, a coordinate or a standard deviation is
 * above kMostPoseCoordinate, or the matrix is no covariance: not symmetric, a negative variance, or
 * a correlation above 1. */
void checkPose(const mrpt::poses::CPose3DPDFGaussian& pose);

}  // namespace mrpt::fusion
