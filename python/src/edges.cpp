// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The structural edges of a map. */

#include <mrpt/fusion/edges.h>
#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "map.h"

using mrpt::fusion::EdgeVoxels;

namespace mrpt_fusion_python {
namespace {

EdgeVoxels edgesOf(const Map& map, const Settings& settings) {
  return mrpt::fusion::extractEdges(mrpt::fusion::extractOccupiedVoxels(map.whole().octree()),
                                    settings.options.features.edges);
}

py::object edgesOf(const py::object& edges_type, const py::object& map_or_path,
                   const py::object& options) {
  const MapPtr map = mapOf(map_or_path);
  const Settings settings = settingsOf(options);
  EdgeVoxels edges;
  std::vector<Eigen::Vector3f> directions;
  std::vector<float> linearity;
  {
    const py::gil_scoped_release release;
    edges = edgesOf(*map, settings);
    for (const auto& c : edges.covariance) {
      directions.emplace_back(c.direction().cast<float>());
      linearity.push_back(static_cast<float>(c.linearity()));
    }
  }
  return edges_type(given(std::move(edges.centre)), given(std::move(directions)),
                    given(std::move(edges.probability)), given(std::move(linearity)));
}

}  // namespace

void bindEdges(py::module_& m) {
  py::list fields;
  for (const char* field : {"centres", "directions", "probabilities", "linearity"})
    fields.append(field);
  const py::object edges_type =
      addNamedTuple(m, "Edges", fields, R"(Structural edge voxels of a map, as arrays of float32.

centres: n x 3 coordinates, m. directions: n x 3 unit vectors along the edges. probabilities: n
probabilities of being occupied. linearity: 1 on a perfect line, 1/3 without a main direction.
)");
  m.def(
      "edges",
      [edges_type](const py::object& map, const py::object& options) {
        return edgesOf(edges_type, map, options);
      },
      py::arg("map"), py::arg("options") = py::dict(),
      R"(edges(map, options={}) -> Edges

Extract the structural edge voxels of a map: where walls meet walls, floors and door frames.

>>> len(mf.edges('a.ot').centres) > 1000
True
)");
}

}  // namespace mrpt_fusion_python
