// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>

#include <Eigen/Geometry>
#include <cstddef>

#include "fusion_core/registration/normal_equations.h"

/** \file
 * How surely a pose is known. */

namespace mrpt::fusion {

/** The largest standard deviation of where a point comes to lie, and of the rotation.
 * \param[in] covariance As poseCovariance(). \param[in] point Where it lies, m, A's frame. */
PoseDeviation deviationAt(const Matrix6d& covariance, const Eigen::Vector3d& point);

/** The covariance of a left perturbation of the pose about the origin of A's frame, from the
 * equations at the optimum: s^2 H^-1 with the residual variance s^2 = error / (3 pairs - 6), and,
 * for what whole patches have in common, H^-1 S H^-1 (the sandwich estimator of clustered data,
 * e.g. Cameron and Miller 2015), which few patches make unsure: with n of them 6 / (6 + n) of it is
 * spread as H^-1 is. Directions with no information get \a unknown_variance. */
Matrix6d poseCovariance(const NormalEquations& at_optimum, size_t pairs,
                        const GradientScatter& scatter = {}, double unknown_variance = 1e6);

}  // namespace mrpt::fusion
