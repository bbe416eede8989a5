// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>

#include <Eigen/Geometry>
#include <cstddef>

/** \file
 * One linearisation of the pairs' error, and how its parts scatter. */

namespace mrpt::fusion {

/** The normal equations of one linearisation: sum of e' W e = error - 2 g' xi + xi' H xi. */
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();                     ///< Hessian
  Vector6d g = Vector6d::Zero();                     ///< right-hand side: H xi = g
  double error = 0;                                  ///< sum of squared Mahalanobis distances
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< c, m

  /** The same equations for steps about another centre, m. */
  NormalEquations about(const Eigen::Vector3d& other) const;
};

/** How the pairs of one patch of B, a cube of some side, together pull at the pose: the
 * scatter of the patches' gradients. What two maps get wrong they get wrong for a whole piece of
 * wall (drift, a door ajar), so the pairs of a patch are not independent; patches nearly are. */
struct GradientScatter {
  Matrix6d S = Matrix6d::Zero();  ///< sum of g g' over the patches, about the same centre as H
  size_t patches = 0;             ///< number of them
};

/** Eigenvalues of H below this share of the largest are rounding, not information. */
constexpr double kNoInformation = 1e-10;

/** [v]x: skew(v) w = v x w. */
inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/** Times a step about a centre \a from: the step about \a to that moves everything alike. */
Matrix6d stepAbout(const Eigen::Vector3d& to, const Eigen::Vector3d& from);

}  // namespace mrpt::fusion
