// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

/** \file
 * Least squares on the poses of a team. */

namespace mrpt::fusion {

/** A measured pose of map \a b in the frame of map \a a. */
struct PoseConstraint {
  size_t a, b;
  Eigen::Isometry3d T_a_b;
  /** Matrix that gives the error of the pose unit variance. The error is the translation in A's
   * frame, m, and the rotation in B's frame, rad. Initially for standard deviations of 0.1 m and
   * 0.01 rad. */
  Matrix6d whitening = (Vector6d() << 10, 10, 10, 100, 100, 100).finished().asDiagonal();
};

/** Returns the constraint of a pose with a covariance, see MatchResult::covariance. */
PoseConstraint constraintOf(size_t a, size_t b, const Eigen::Isometry3d& T_a_b,
                            const Matrix6d& covariance);

/** Optimises poses on SE(3) so that they fit the constraints, with Ceres. A constraint that does
 * not fit loses weight (Cauchy's loss). \param[in] constraints Constraints between maps that have
 * poses. \param[in,out] pose Poses in one frame. Of the maps that constraints connect with each
 * other, the first keeps its pose. */
void optimizePoses(const std::vector<PoseConstraint>& constraints,
                   std::vector<std::optional<Eigen::Isometry3d>>& pose);

/** Optimises poses as optimizePoses(), and computes their joint covariance. A constraint loses half
 * of its weight at the 95 % bound of its covariance.
 *
 * Loops measure whether the covariances of the constraints are right. If the constraints disagree
 * more than their covariances say, all covariances are multiplied by the ratio. Few loops measure
 * it badly: the ratio is that of the loops and of 6 more degrees of freedom that agree.
 *
 * Cost: a sparse QR decomposition.
 * \param[in] constraints Constraints of all poses but the first; they connect all of them.
 * \param[in,out] pose Poses in one frame. The first pose keeps its value.
 * \return For each map the covariance of its pose in the frame of the poses, see
 * MatchResult::covariance: zero for the first pose and for maps without a pose. */
std::vector<Matrix6d> optimizeWithCovariance(const std::vector<PoseConstraint>& constraints,
                                             std::vector<std::optional<Eigen::Isometry3d>>& pose);

}  // namespace mrpt::fusion
