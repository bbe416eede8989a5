// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Maps from point clouds. */

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/format.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <pybind11/stl.h>

#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

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
    mrpt::config::CConfigFileMemory file, defaults;
    file.setContent(iniText(options, kSection));
    map_.insertionOptions.saveToConfigFile(defaults, kSection);
    defaults.setContent(defaults.getContent());  // MRPT pads keys until they are parsed
    checkKeys(file, defaults, kSection);
    map_.insertionOptions.loadFromConfigFile(file, kSection);
  }

  /** Inserts points, with the rays from a sensor if there is one. Points outside of the grid are
   * left out. \return Number of points that are left out.
   * \exception std::runtime_error If the sensor is outside of the grid. */
  size_t insert(const std::vector<Eigen::Vector3f>& points,
                const std::optional<Eigen::Vector3f>& sensor) {
    if (sensor && !isInGrid(*sensor)) throw std::runtime_error("the sensor is " + outsideText());
    size_t outside = 0;
    mrpt::maps::CSimplePointsMap cloud;
    cloud.reserve(points.size());
    for (const Eigen::Vector3f& p : points) {
      if (!isInGrid(sensor ? beamEnd(*sensor, p) : p)) outside++;
      cloud.insertPointFast(p.x(), p.y(), p.z());
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (sensor)
      map_.insertPointCloud(cloud, sensor->x(), sensor->y(), sensor->z());
    else
      map_.insertPointCloud(cloud);
    return outside;
  }

  /** Says where the grid ends. */
  std::string outsideText() const {
    return mrpt::format("outside of the grid of the map, which ends %g m from the origin",
                        kGridVoxels * map_.getResolution());
  }

  MapPtr map() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::make_shared<Map>(std::make_shared<const CProbOctoMap>(map_), Origin());
  }

 private:
  static constexpr double kGridVoxels = 32768;  // on each side of the origin

  bool isInGrid(const Eigen::Vector3f& p) const {
    const Eigen::Array3d voxel = (p.cast<double>() * (1 / map_.getResolution())).array().floor();
    return (voxel >= -kGridVoxels).all() && (voxel < kGridVoxels).all();
  }

  /** Returns the point at which the beam to a point ends. */
  Eigen::Vector3f beamEnd(const Eigen::Vector3f& sensor, const Eigen::Vector3f& point) const {
    const Eigen::Vector3d beam = (point - sensor).cast<double>();
    const double range = map_.insertionOptions.maxrange;
    if (range < 0 || !(beam.norm() > range)) return point;
    return (sensor.cast<double>() + range * beam.normalized()).cast<float>();
  }

  std::mutex mutex_;
  CProbOctoMap map_;
};

/** Inserts points of the frame of the sensor. \return Number of points outside of the grid. */
size_t insertScan(MapBuilder& builder, const DoubleArray& points,
                  const std::optional<DoubleArray>& pose, bool rays) {
  checkPoints(points, "points");
  const Eigen::Isometry3d T = pose ? poseOf(*pose) : Eigen::Isometry3d::Identity();
  const auto p = points.unchecked<2>();
  const py::gil_scoped_release release;
  std::vector<Eigen::Vector3f> in_map;
  in_map.reserve(static_cast<size_t>(p.shape(0)));
  for (py::ssize_t i = 0; i < p.shape(0); i++) {
    const Eigen::Vector3d q = T * Eigen::Vector3d(p(i, 0), p(i, 1), p(i, 2));
    if (q.allFinite()) in_map.emplace_back(q.cast<float>());
  }
  std::optional<Eigen::Vector3f> sensor;
  if (rays) sensor = T.translation().cast<float>();
  return builder.insert(in_map, sensor);
}

void warnOf(size_t outside, const MapBuilder& builder) {
  if (outside == 0) return;
  warn(std::to_string(outside) + (outside == 1 ? " point is" : " points are") +
       " left out: " + builder.outsideText());
}

void insert(MapBuilder& builder, const DoubleArray& points, const std::optional<DoubleArray>& pose,
            bool rays) {
  warnOf(insertScan(builder, points, pose, rays), builder);
}

py::object snapshotOf(MapBuilder& builder) {
  MapPtr map;
  {
    const py::gil_scoped_release release;
    map = builder.map();
  }
  return toPython(map);
}

using Scan = std::pair<DoubleArray, std::optional<DoubleArray>>;  // points, pose of the sensor

/** \exception pybind11::type_error If the object is not a pair of points and a pose. */
Scan scanOf(const py::handle& object) {
  if (!py::isinstance<py::array>(object)) {
    try {
      auto scan = object.cast<Scan>();
      if (scan.first.ndim() == 2) return scan;
    } catch (const py::cast_error&) {  // the reason says nothing of scans
    }
  }
  throw py::type_error("each scan is a pair (points, pose)");
}

py::object mapOfScans(const py::iterable& scans, double resolution, const py::dict& options) {
  MapBuilder builder(resolution, options);
  size_t outside = 0;
  for (const py::handle object : scans) {
    const Scan scan = scanOf(object);
    outside += insertScan(builder, scan.first, scan.second, true);
  }
  warnOf(outside, builder);
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
Points that are not numbers are left out. Points outside of the grid of the map (32768 voxels from the
origin) are left out with a warning. A sensor outside of the grid is an Error.
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
