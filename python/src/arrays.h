// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

/** \file
 * Arrays of points from and to numpy. */

namespace mrpt_fusion_python {

namespace py = pybind11;

/** Array of floats in the order of C. Other arrays and lists are converted. */
using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

/** Gives a vector of floats or of points to numpy without copying it.
 * \param[in] shape Shape of the array; its product is the number of floats. */
template <class T>
py::array_t<float> given(std::vector<T> values, std::vector<py::ssize_t> shape) {
  auto kept = std::make_unique<std::vector<T>>(std::move(values));
  const auto* data = reinterpret_cast<const float*>(kept->data());
  const py::capsule owner(kept.release(), [](void* v) { delete static_cast<std::vector<T>*>(v); });
  return py::array_t<float>(std::move(shape), data, owner);
}
/** Gives numbers to numpy. */
inline py::array_t<float> given(std::vector<float> values) {
  const auto n = static_cast<py::ssize_t>(values.size());
  return given(std::move(values), {n});
}
/** Gives points to numpy, as an array of n x 3. */
inline py::array_t<float> given(std::vector<Eigen::Vector3f> points) {
  const auto n = static_cast<py::ssize_t>(points.size());
  return given(std::move(points), {n, 3});
}

/** Checks that an array has n x 3 numbers. \exception pybind11::value_error If it has not. */
inline void checkPoints(const py::array& points, const char* name) {
  if (points.ndim() != 2 || points.shape(1) != 3)
    throw py::value_error(std::string(name) + " is not an array of n x 3 numbers");
}

/** Returns the class of a named tuple, and adds it to a module. */
inline py::object addNamedTuple(py::module_& m, const char* name, const py::list& fields,
                                const char* doc) {
  py::object type = py::module_::import("collections").attr("namedtuple")(name, fields);
  type.attr("__module__") = "mrpt_fusion";
  type.attr("__doc__") = doc;
  m.attr(name) = type;
  return type;
}

}  // namespace mrpt_fusion_python
