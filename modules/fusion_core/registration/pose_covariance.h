// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "fusion_core/registration/normal_equations.h"

/** \file
 * The covariance of a pose. */

namespace mrpt::fusion {

/** Standard deviation above which nothing holds a direction, m or rad. */
constexpr double kFreeDeviation = 100;

/** Returns the largest standard deviations of a point of B and of the rotation, with their
 * directions. A direction is free if its standard deviation is above kFreeDeviation. A map that
 * turns freely about one axis moves its far points, too: then the directions are those of the
 * translation at a fixed rotation.
 * \param[in] covariance Covariance as from poseCovariance().
 * \param[in] point The point, m, A's frame. */
PoseDeviation deviationAt(const Matrix6d& covariance, const Eigen::Vector3d& point);

/** Returns the covariance of a left perturbation of the pose about the origin of A's frame.
 *
 * It is the sum of two terms. The first term is s^2 H^-1 with the residual variance
 * s^2 = error / (3 pairs - 6). The second term is H^-1 S H^-1, for the errors that the pairs of a
 * patch have in common (the sandwich estimator of clustered data, e.g. Cameron and Miller 2015).
 * With few patches the scatter S is noisy. It is shrunk towards a multiple of H^-1 with weight
 * 6 / (6 + n), n = number of patches. Directions without information get \a unknown_variance.
 * \param[in] at_optimum Normal equations at the optimum.
 * \param[in] pairs Number of pairs.
 * \param[in] scatter Scatter of the patches' gradients.
 * \param[in] unknown_variance Variance of directions without information, m^2 or rad^2. */
Matrix6d poseCovariance(const NormalEquations& at_optimum, size_t pairs,
                        const GradientScatter& scatter = {}, double unknown_variance = 1e6);

/** Returns the covariance of a left perturbation of the pose about the origin of A's frame, for
 * errors that all pairs have in common: a shift, and a linear field u = G r at the distance r from
 * the middle. Floors and walls along the grid have the same offset from the centres of their
 * voxels, and a map may be bent or tilted by a part of a voxel. These errors do not show in the
 * residuals, because a rigid pose fits them. \param[in] points Points of the pairs, m, any frame.
 * \param[in] of_shift Variance of the shift in each direction, m^2.
 * \param[in] of_bend Variance of u in each direction, at the RMS distance, m^2.
 * \param[in] centre Middle of the pairs, m, A's frame. */
Matrix6d commonCovariance(const std::vector<Eigen::Vector3f>& points, double of_shift,
                          double of_bend, const Eigen::Vector3d& centre);

}  // namespace mrpt::fusion
