// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * OctoMap's own insertion of point clouds, for comparison. */

#include <octomap/OcTree.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <sstream>
#include <vector>

namespace py = pybind11;

namespace {

using Points = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Scan = std::pair<Points, std::array<float, 3>>;

/** Returns the .ot file of scans: points and position of the sensor, both in the map's frame. */
py::bytes insert(const std::vector<Scan>& scans, double resolution, double max_range) {
  octomap::OcTree tree(resolution);
  for (const auto& [points, origin] : scans) {
    octomap::Pointcloud cloud;
    const auto p = points.unchecked<2>();
    for (py::ssize_t i = 0; i < p.shape(0); i++) cloud.push_back(p(i, 0), p(i, 1), p(i, 2));
    tree.insertPointCloud(cloud, {origin[0], origin[1], origin[2]}, max_range, true);
    tree.updateInnerOccupancy();
    tree.prune();
  }
  std::ostringstream file;
  tree.write(file);
  return file.str();
}

}  // namespace

PYBIND11_MODULE(octomap_twin, m) { m.def("insert", &insert); }
