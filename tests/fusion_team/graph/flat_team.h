// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

/** \file
 * Poses and boxes of made-up teams on a plane. */

namespace mrpt::fusion::test {

inline Eigen::Isometry3d at(double x, double y, double yaw = 0) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(Eigen::Vector3d(x, y, 0));
  T.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return T;
}

/** A box that meets all boxes. */
inline Eigen::AlignedBox3d everywhere() {
  return {Eigen::Vector3d::Constant(-1e3), Eigen::Vector3d::Constant(1e3)};
}

}  // namespace mrpt::fusion::test
