// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Map: an immutable value that is prepared for matching once. */

#include "map.h"

#include <mrpt/fusion/fusion.h>
#include <mrpt/fusion/voxels.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "bindings.h"
#include "fusion_report/report.h"
#include "poses.h"

using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;

namespace mrpt_fusion_python {

Origin Origin::of(std::string path) {
  const std::string name = std::filesystem::path(path).filename().replace_extension().string();
  return {name, std::move(path), {{{}, name, 0, 0}}};
}

Map::Map(std::shared_ptr<const CProbOctoMap> whole, Origin origin)
    : whole_(std::move(whole)), octree_(whole_, &whole_->octree()), origin_(std::move(origin)) {}

Map::Map(std::shared_ptr<const CEdgeVoxelMap> edges, Origin origin)
    : edges_(std::move(edges)),
      octree_(std::make_shared<const octomap::OcTree>(edges_->asOcTree())),
      origin_(std::move(origin)) {}

std::shared_ptr<Map> Map::from(const CMetricMap::ConstPtr& map, Origin origin) {
  if (auto edges = std::dynamic_pointer_cast<const CEdgeVoxelMap>(map))
    return std::make_shared<Map>(std::move(edges), std::move(origin));
  auto whole = mrpt::fusion::asProbOctoMap(map);
  if (!whole)
    throw std::runtime_error(std::string("a ") + map->GetRuntimeClass()->className +
                             " is not, and holds no, 3-D occupancy map");
  return std::make_shared<Map>(std::move(whole), std::move(origin));
}

const CProbOctoMap& Map::whole() const {
  if (!whole_) throw std::runtime_error("the map has only structural edges");
  return *whole_;
}

const CMetricMap& Map::metricMap() const {
  if (whole_) return *whole_;
  return *edges_;
}

mrpt::fusion::Sources Map::sources() const {
  mrpt::fusion::Sources sources;
  if (whole_) sources = whole_->sources();
  return sources.empty() ? origin_.sources : sources;
}

mrpt::fusion::PreparedMap Map::prepared(const Settings& settings) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (prepared_ && prepared_by_ == settings.text) return *prepared_;
  const auto& features = settings.options.features;
  prepared_ = edges_ ? mrpt::fusion::PreparedMap(edges_->edges(), features)
                     : mrpt::fusion::PreparedMap(octree_, features).withSources(sources());
  prepared_by_ = settings.text;
  return *prepared_;
}

MapPtr mapOf(std::unique_ptr<octomap::OcTree> octree, mrpt::fusion::Sources sources) {
  auto map = std::make_shared<CProbOctoMap>(std::move(octree));
  map->setSources(std::move(sources));
  return std::make_shared<Map>(std::move(map), Origin());
}

py::object toPython(const MapPtr& map) {
  if (!map) return py::none();
  return py::cast(std::const_pointer_cast<Map>(map));  // no function of Python changes it
}

namespace {

std::string representation(const Map& map) {
  std::ostringstream out;
  out << "<mrpt_fusion.Map";
  if (!map.origin().name.empty()) out << " '" << map.origin().name << "'";
  out << (map.isEdgesAlone() ? " of edges" : "") << ", voxels of " << map.octree()->getResolution()
      << " m, " << map.octree()->size() << " nodes>";
  return out.str();
}

py::array_t<double> boundsOf(const Map& map) {
  const auto report = mrpt::fusion::reportOn("", "", *map.octree());
  Eigen::Matrix<double, 2, 3> bounds;
  bounds << Eigen::RowVector3d(report.low), Eigen::RowVector3d(report.high);
  return arrayOf(bounds);
}

/** Returns the sources of a map with the hashes of their voxels. The hash of a map that is a source
 * of its own is computed. Edges alone do not know it. */
mrpt::fusion::Sources hashedSourcesOf(const Map& map) {
  const mrpt::fusion::Sources sources = map.sources();
  const bool are_hashed = std::all_of(sources.begin(), sources.end(),
                                      [](const auto& s) { return s.content_hash != 0; });
  if (are_hashed || map.isEdgesAlone()) return sources;
  CProbOctoMap copy(map.whole());
  copy.setSources(sources);
  return copy.sources();
}

py::list sourcesOf(const Map& map) {
  mrpt::fusion::Sources hashed;
  {
    const py::gil_scoped_release release;
    hashed = hashedSourcesOf(map);
  }
  py::list sources;
  for (const auto& s : hashed) {
    py::dict source(py::arg("robot") = s.robot, py::arg("map") = s.map,
                    py::arg("sequence") = s.sequence);
    if (s.content_hash != 0) source["content_hash"] = s.content_hash;
    sources.append(source);
  }
  return sources;
}

}  // namespace

void bindMap(py::module_& m) {
  py::class_<Map, std::shared_ptr<Map>>(m, "Map", R"(A 3-D occupancy map, or structural edges alone.

A map is a value: no function changes it. So several threads may use it at once, and it is
prepared for matching only once. load(), Map.from_bytes(), Map.from_voxels(), Map.from_scans() and
MapBuilder make maps.

>>> mf.load('a.ot')
<mrpt_fusion.Map 'a', voxels of 0.1 m, 289089 nodes>
)")
      .def_property_readonly(
          "resolution", [](const Map& map) { return map.octree()->getResolution(); },
          "Voxel size, m.")
      .def_property_readonly(
          "nodes", [](const Map& map) { return map.octree()->size(); },
          "Number of nodes of the octree.")
      .def_property_readonly("bounds", &boundsOf,
                             "Lowest and highest corner of the known space, m: a 2x3 array.")
      .def_property_readonly("edges_alone", &Map::isEdgesAlone,
                             "True if the map has only structural edges. It can be matched, but "
                             "not merged.")
      .def_property_readonly(
          "name", [](const Map& map) { return map.origin().name; },
          "Name of the file without extension, or of the robot; or ''.")
      .def_property_readonly("sources", &sourcesOf,
                             "Sources of the map: a list of dicts. No observation of a source "
                             "counts twice in a fused map. content_hash is the hash of the voxels "
                             "of the source; sources of edges have none. Cost for a map that is "
                             "not fused: a copy.")
      .def("__repr__", &representation);
}

}  // namespace mrpt_fusion_python
