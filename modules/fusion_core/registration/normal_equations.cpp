// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Moves normal equations to another centre. */
#include "fusion_core/registration/normal_equations.h"

namespace mrpt::fusion {

Matrix6d stepAbout(const Eigen::Vector3d& to, const Eigen::Vector3d& from) {
  Matrix6d J = Matrix6d::Identity();  // a rotation w about `from` moves `to` by w x (to - from)
  J.topRightCorner<3, 3>() = skew(from - to);
  return J;
}

NormalEquations NormalEquations::about(const Eigen::Vector3d& other) const {
  const Matrix6d J = stepAbout(centre, other);
  return {J.transpose() * H * J, J.transpose() * g, error, other};
}

}  // namespace mrpt::fusion
