// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/registration_params.h>

#include <Eigen/Geometry>

#include "fusion_core/registration/two_level.h"

/** \file
 * How firmly the pairs of two maps hold a pose in each direction. */

namespace mrpt::fusion {

/** Covariance of a pose by the pairs of the voxel level there, see MatchResult::covariance.
 * \param[in] step See heldHessian(), m. */
Matrix6d covarianceAt(VoxelLevel& level, const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                      double step, const CovarianceParams& params);

/** The Hessian, as far as the maps hold the pose. The Hessian of the normal equations is that of
 * given pairs; but a wall that slides along itself pairs with the next piece of itself. So each of
 * the eigenvectors counts only as far as the pull back to the pose grows when B is moved along it,
 * by a \a step (m) to either side, and paired anew. */
Matrix6d heldHessian(LevelProblem& level, const NormalEquations& equations, const Pairs& pairs,
                     const Eigen::Isometry3d& T_a_b, double step, const CovarianceParams& params);

}  // namespace mrpt::fusion
