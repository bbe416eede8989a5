// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Converts poses and priors from Python. */

#include "poses.h"

#include <algorithm>
#include <cmath>
#include <exception>

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

py::array_t<double> covarianceArrayOf(const mrpt::poses::CPose3DPDFGaussian& pose) {
  return arrayOf(mrpt::fusion::fromYawPitchRollCovariance(pose.cov.asEigen(), toEigen(pose.mean)));
}

Prior priorOf(const std::optional<DoubleArray>& guess, const std::optional<Sigma>& sigma) {
  if (!guess) {
    if (sigma) throw py::value_error("guess_sigma needs a guess");
    return Prior::none();
  }
  const mrpt::poses::CPose3D pose = toPose(poseOf(*guess));
  return sigma ? Prior::within(pose, sigma->first, mrpt::DEG2RAD(sigma->second))
               : Prior::near(pose);
}

}  // namespace mrpt_fusion_python
