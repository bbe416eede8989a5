// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Maps from point clouds. */

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <pybind11/stl.h>

#include <mutex>

#include "arrays.h"
#include "bindings.h"
#include "map.h"
#include "poses.h"
#include "settings.h"

using mrpt::maps::CProbOctoMap;

namespace mrpt_fusion_python {
namespace {

/** A map that grows by point clouds. Several threads may use it. */
class MapBuilder {
 public:
  MapBuilder(double resolution, const py::dict& options) : map_(resolution) {
    constexpr const char* kSection = "options";
    mrpt::config::CConfigFileMemory file;
    file.setContent(iniText(options, kSection));
    map_.insertionOptions.loadFromConfigFile(file, kSection);
  }

  void insert(const mrpt::maps::CSimplePointsMap& points, const Eigen::Vector3f& sensor,
              bool rays) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (rays)
      map_.insertPointCloud(points, sensor.x(), sensor.y(), sensor.z());
    else
      map_.insertPointCloud(points);
  }

  MapPtr map() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::make_shared<Map>(std::make_shared<const CProbOctoMap>(map_), Origin());
  }

 private:
  std::mutex mutex_;
  CProbOctoMap map_;
};

void insert(MapBuilder& builder, const DoubleArray& points, const std::optional<DoubleArray>& pose,
            bool rays) {
  checkPoints(points, "points");
  const Eigen::Isometry3d T = pose ? poseOf(*pose) : Eigen::Isometry3d::Identity();
  const auto p = points.unchecked<2>();
  const py::gil_scoped_release release;
  mrpt::maps::CSimplePointsMap in_map;
  in_map.resize(static_cast<size_t>(p.shape(0)));
  for (py::ssize_t i = 0; i < p.shape(0); i++) {
    const Eigen::Vector3f q = (T * Eigen::Vector3d(p(i, 0), p(i, 1), p(i, 2))).cast<float>();
    in_map.setPointFast(static_cast<size_t>(i), q.x(), q.y(), q.z());
  }
  builder.insert(in_map, T.translation().cast<float>(), rays);
}

py::object snapshotOf(MapBuilder& builder) {
  MapPtr map;
  {
    const py::gil_scoped_release release;
    map = builder.map();
  }
  return toPython(map);
}

py::object mapOfScans(const py::iterable& scans, double resolution, const py::dict& options) {
  MapBuilder builder(resolution, options);
  for (const py::handle scan : scans) {
    const auto [points, pose] = scan.cast<std::pair<DoubleArray, std::optional<DoubleArray>>>();
    insert(builder, points, pose, true);
  }
  return snapshotOf(builder);
}

}  // namespace

void bindInsertion(py::module_& m) {
  py::class_<MapBuilder>(m, "MapBuilder", R"(MapBuilder(resolution=0.1, options={})

A map that grows by point clouds. Each voxel has the log-odds of OctoMap, bit for bit. Several threads
may use it.

resolution: voxel size, m. options: a dict with the insertion options of
map_from_recording.ini: maxrange (m; -1: whole beams), pruning, occupancyThres, probHit, probMiss,
clampingThresMin, clampingThresMax.

>>> builder = mf.MapBuilder(0.5, {'maxrange': 20})
>>> builder.insert([[2.2, 0.2, 0.2]])
>>> p = builder.map().probability_at([[2.2, 0.2, 0.2], [1.2, 0.2, 0.2]])
>>> p.round(2).tolist()
[0.7, 0.4]
)")
      .def(py::init<double, const py::dict&>(), py::arg("resolution") = 0.1,
           py::arg("options") = py::dict())
      .def("insert", &insert, py::arg("points"), py::arg("pose") = py::none(), py::kw_only(),
           py::arg("rays") = true,
           R"(insert(points, pose=None, *, rays=True) -> None

Insert n x 3 points in the frame of the sensor, m. pose is the 4x4 pose of the sensor in the map. The
space between sensor and points becomes free. With rays=False only the voxels of the points change.
Points that are not numbers are left out.
)")
      .def("map", &snapshotOf, R"(map() -> Map

Return the map as it is now. The result does not change. Cost: a copy.
)");
  py::class_<Map, std::shared_ptr<Map>> map{py::object(m.attr("Map"))};
  map.def_static("from_scans", &mapOfScans, py::arg("scans"), py::arg("resolution") = 0.1,
                 py::arg("options") = py::dict(),
                 R"(from_scans(scans, resolution=0.1, options={}) -> Map

Return the map of scans: an iterable of pairs (points, pose), see MapBuilder.insert().

>>> mf.Map.from_scans([([[1, 0, 0]], None), ([[0, 2, 0]], None)], 0.2)
<mrpt_fusion.Map, voxels of 0.2 m, 41 nodes>
)");
}

}  // namespace mrpt_fusion_python
