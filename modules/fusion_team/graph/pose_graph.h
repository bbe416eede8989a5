// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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
  double sigma_translation = 0.1;  ///< Standard deviation, m
  double sigma_rotation = 0.01;    ///< Standard deviation, rad
};

/** Optimises poses on SE(3) so that they fit the constraints, with Ceres. A constraint that does
 * not fit loses weight (Cauchy's loss). \param[in] constraints Constraints between maps that have
 * poses. \param[in,out] pose Poses in one frame. The first pose keeps its value; poses without
 * constraints too. */
void optimizePoses(const std::vector<PoseConstraint>& constraints,
                   std::vector<std::optional<Eigen::Isometry3d>>& pose);

}  // namespace mrpt::fusion
