// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/registration_params.h>

#include <Eigen/Geometry>

#include "fusion_core/registration/two_level.h"

/** \file
 * Tests in which directions the pairs of two maps hold a pose. */

namespace mrpt::fusion {

/** Returns the covariance of a pose from the pairs of the voxel level at that pose, see
 * MatchResult::covariance.
 * \param[in] level The voxel level.
 * \param[in] pairs Its pairs at T_a_b.
 * \param[in] T_a_b Pose of map B in A's frame.
 * \param[in] step See heldHessian(), m.
 * \param[in] params Settings of the covariance. */
Matrix6d covarianceAt(VoxelLevel& level, const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                      double step, const CovarianceParams& params);

/** Returns the Hessian, reduced in the directions in which the maps do not hold the pose.
 *
 * The Hessian of the normal equations assumes fixed pairs. But a wall that slides along itself
 * pairs with the next piece of itself. So B is moved along each eigenvector, by \a step (m) to
 * either side, and is paired again. Each eigenvalue is multiplied by the pull back to the pose over
 * the expected pull, at most 1; by 0 if this ratio is below CovarianceParams::min_pull. */
Matrix6d heldHessian(LevelProblem& level, const NormalEquations& equations, const Pairs& pairs,
                     const Eigen::Isometry3d& T_a_b, double step, const CovarianceParams& params);

}  // namespace mrpt::fusion
