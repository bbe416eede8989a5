// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Converts poses and priors from Python. */

#include "poses.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

using mrpt::fusion::Prior;
using mrpt::fusion::toEigen;
using mrpt::fusion::toPose;

namespace mrpt_fusion_python {

Eigen::Isometry3d poseOf(const DoubleArray& matrix) {
  if (matrix.ndim() != 2 || matrix.shape(0) != 4 || matrix.shape(1) != 4)
    throw py::value_error("a pose is a 4x4 matrix");
  try {
    return mrpt::fusion::toRigid(
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(matrix.data()));
  } catch (const std::exception& e) {
    throw py::value_error(e.what());
  }
}

Eigen::Isometry3d poseOf(const py::object& pose, const std::string& name) {
  const auto matrix = DoubleArray::ensure(pose);
  if (!matrix)
    throw py::type_error(name + " is a 4x4 matrix: an array of numpy, or 4 lists of 4 numbers");
  return poseOf(matrix);
}

py::array_t<double> covarianceArrayOf(const mrpt::poses::CPose3DPDFGaussian& pose) {
  return arrayOf(mrpt::fusion::fromYawPitchRollCovariance(pose.cov.asEigen(), toEigen(pose.mean)));
}

Prior priorOf(const py::object& guess, const py::object& sigma) {
  if (guess.is_none()) {
    if (!sigma.is_none()) throw py::value_error("guess_sigma needs a guess");
    return Prior::none();
  }
  const mrpt::poses::CPose3D pose = toPose(poseOf(guess, "guess"));
  if (sigma.is_none()) return Prior::near(pose);
  try {
    const auto [position, heading] = sigma.cast<std::pair<double, double>>();
    return Prior::within(pose, position, mrpt::DEG2RAD(heading));
  } catch (const py::cast_error&) {
    throw py::type_error(
        "guess_sigma is a pair: standard deviations of the position (m) and of the heading (deg)");
  }
}

}  // namespace mrpt_fusion_python
