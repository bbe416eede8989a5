// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The voxels of a map as arrays of numpy, and back. */

#include <mrpt/fusion/voxels.h>
#include <pybind11/stl.h>

#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "arrays.h"
#include "bindings.h"
#include "map.h"
#include "poses.h"

using mrpt::fusion::Cubes;
using mrpt::fusion::KnownSpace;

namespace mrpt_fusion_python {
namespace {

KnownSpace partOf(const std::string& space) {
  static const std::map<std::string, KnownSpace> parts = {
      {"occupied", KnownSpace::Occupied}, {"free", KnownSpace::Free}, {"all", KnownSpace::All}};
  const auto part = parts.find(space);
  if (part == parts.end()) throw py::value_error("the space is 'occupied', 'free' or 'all'");
  return part->second;
}

py::object voxelsOf(const py::object& cubes_type, const Map& map, const std::string& space) {
  const KnownSpace part = partOf(space);
  Cubes cubes;
  {
    const py::gil_scoped_release release;
    cubes = mrpt::fusion::cubesOf(*map.octree(), part);
  }
  return cubes_type(given(std::move(cubes.centre)), given(std::move(cubes.log_odds)),
                    given(std::move(cubes.size)));
}

std::vector<float> numbersOf(const FloatArray& array, const char* name) {
  if (array.ndim() != 1) throw py::value_error(std::string(name) + " is not an array of n numbers");
  return {array.data(), array.data() + array.size()};
}

MapPtr mapOfVoxels(const FloatArray& centres, const FloatArray& log_odds,
                   const std::optional<FloatArray>& sizes, double resolution) {
  Cubes cubes;
  cubes.resolution = resolution;
  checkPoints(centres, "centres");
  const auto* points = reinterpret_cast<const Eigen::Vector3f*>(centres.data());
  cubes.centre.assign(points, points + centres.shape(0));
  cubes.log_odds = numbersOf(log_odds, "log_odds");
  if (sizes) cubes.size = numbersOf(*sizes, "sizes");
  const py::gil_scoped_release release;
  return mapOf(mrpt::fusion::octreeOf(cubes), {});
}

py::array_t<double> probabilityAt(const Map& map, const FloatArray& points) {
  checkPoints(points, "points");
  py::array_t<double> result(points.shape(0));
  const auto p = points.unchecked<2>();
  auto out = result.mutable_unchecked<1>();
  const auto& whole = map.whole();
  const py::gil_scoped_release release;
  for (py::ssize_t i = 0; i < p.shape(0); i++) {
    double probability = std::numeric_limits<double>::quiet_NaN();
    whole.getPointOccupancy(p(i, 0), p(i, 1), p(i, 2), probability);
    out(i) = probability;
  }
  return result;
}

}  // namespace

void bindVoxels(py::module_& m) {
  py::list fields;
  for (const char* field : {"centres", "log_odds", "sizes"}) fields.append(field);
  const py::object cubes_type =
      addNamedTuple(m, "Cubes", fields,
                    R"(Known space of a map as cubes, as arrays of float32.

centres: n x 3 coordinates, m. log_odds: n log-odds of being occupied. sizes: n lengths of the
sides, m: the voxel size times a power of 2.
)");
  py::class_<Map, std::shared_ptr<Map>> map{py::object(m.attr("Map"))};
  map.def(
      "voxels",
      [cubes_type](const Map& self, const std::string& space) {
        return voxelsOf(cubes_type, self, space);
      },
      py::arg("space") = "occupied",
      R"(voxels(space='occupied') -> Cubes

Return the voxels of the map, in the order of the octree. space is 'occupied', 'free' or 'all'.
Equal voxels may be one larger cube.

>>> centres, log_odds, sizes = mf.load('a.ot').voxels('all')
>>> centres.shape[1], log_odds.dtype
(3, dtype('float32'))
)");
  map.def_static(
      "from_voxels",
      [](const FloatArray& centres, const FloatArray& log_odds,
         const std::optional<FloatArray>& sizes,
         double resolution) { return toPython(mapOfVoxels(centres, log_odds, sizes, resolution)); },
      py::arg("centres"), py::arg("log_odds"), py::arg("sizes") = py::none(), py::kw_only(),
      py::arg("resolution"),
      R"(from_voxels(centres, log_odds, sizes=None, *, resolution) -> Map

Return the map of voxels or larger cubes: the inverse of voxels('all'). Without sizes, all cubes
are voxels. Space without a cube is unknown. Log-odds are kept bit for bit.

>>> a = mf.load('a.ot')
>>> again = mf.Map.from_voxels(*a.voxels('all'), resolution=a.resolution)
>>> again.to_bytes() == a.to_bytes()
True
)");
  map.def("probability_at", &probabilityAt, py::arg("points"),
          R"(probability_at(points) -> numpy.ndarray

Return the probability of being occupied at n x 3 points, m. nan: unknown.

>>> mf.Map.from_voxels([[0, 0, 0]], [0.0], resolution=1).probability_at([[0, 0, 0], [9, 9, 9]])
array([0.5, nan])
)");
}

}  // namespace mrpt_fusion_python
