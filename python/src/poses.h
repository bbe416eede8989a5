// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/poses.h>
#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>

/** \file
 * Poses, matrices and priors from and to numpy. */

namespace mrpt_fusion_python {

namespace py = pybind11;

/** Array of doubles in the order of C. Other arrays and lists are converted. */
using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

/** Returns a pose. \exception pybind11::value_error If it is not a rigid 4x4 matrix. */
Eigen::Isometry3d poseOf(const DoubleArray& matrix);
/** Returns the pose that an argument is. \param[in] name Name of the argument.
 * \exception pybind11::type_error If it holds no numbers, or see above. */
Eigen::Isometry3d poseOf(const py::object& pose, const std::string& name);

/** Returns a matrix as an array of numpy. */
template <class Matrix>
py::array_t<double> arrayOf(const Matrix& matrix) {
  py::array_t<double> array({matrix.rows(), matrix.cols()});
  auto out = array.template mutable_unchecked<2>();
  for (py::ssize_t row = 0; row < matrix.rows(); row++)
    for (py::ssize_t col = 0; col < matrix.cols(); col++) out(row, col) = matrix(row, col);
  return array;
}
/** Returns a pose as a 4x4 array. */
inline py::array_t<double> arrayOf(const Eigen::Isometry3d& T) {
  return arrayOf(Eigen::Matrix4d(T.matrix()));
}
/** Returns the covariance of a left perturbation (translation, rotation; m, rad) as a 6x6 array. */
py::array_t<double> covarianceArrayOf(const mrpt::poses::CPose3DPDFGaussian& pose);

/** Returns what a guess says about the pose of B in A, as --init and --init-sigma do.
 * \param[in] guess A pose, or None. \param[in] sigma Standard deviations of the position, m, and of
 * the heading, deg; or None. \exception pybind11::type_error If they are something else. */
mrpt::fusion::Prior priorOf(const py::object& guess, const py::object& sigma);

}  // namespace mrpt_fusion_python
