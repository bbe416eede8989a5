// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Maps from and to files, bytes and pickles. */

#include "fusion_base/files.h"

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/fusion/map_files.h>
#include <mrpt/serialization/CSerializable.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "bindings.h"
#include "fusion_base/error_text.h"
#include "map.h"
#include "poses.h"

using mrpt::fusion::withPath;
using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;

namespace mrpt_fusion_python {
namespace {

/** How a recording becomes a map, and what was noted. Python hears of the notes. */
class Reading {
 public:
  explicit Reading(std::string path) : path_(std::move(path)) {
    params_.note = [this](const std::string& note) { notes_.push_back(path_ + ": " + note); };
  }

  /** Uses the map definition of an .ini file. */
  void useConfig(const std::string& path) {
    constexpr size_t kMostBytes = size_t{16} << 20U;
    withPath(path, [&] { config_.setContent(mrpt::fusion::readFileBytes(path, kMostBytes)); });
    if (!config_.sectionExists(params_.section))
      throw std::runtime_error(path + ": has no section [" + params_.section + "]");
    params_.config = &config_;
  }

  /** Makes maps of point clouds with voxels of a size, m. */
  void useResolution(double resolution) { params_.cloud_resolution = resolution; }

  /** Makes maps of point clouds that are seen from a position, m. */
  void useSensorOrigin(const DoubleArray& origin) {
    const auto* p = origin.data();
    if (origin.ndim() != 1 || origin.size() != 3 ||
        !std::all_of(p, p + 3, [](double x) { return std::isfinite(x); }))
      throw py::value_error("sensor_origin is not an array of 3 numbers");
    params_.cloud_sensor_origin.emplace(p[0], p[1], p[2]);
  }

  /** Calls f with the path and the parameters, without the GIL. */
  template <class F>
  auto run(F&& f) {
    auto result = [&] {
      const py::gil_scoped_release release;
      return f(path_, params_);
    }();
    for (const std::string& note : notes_) warn(note);
    return result;
  }

 private:
  std::string path_;
  mrpt::config::CConfigFileMemory config_;
  mrpt::fusion::BuildParams params_;
  std::vector<std::string> notes_;
};

std::shared_ptr<Map> load(const py::object& path, const py::object& config,
                          std::optional<double> resolution,
                          const std::optional<DoubleArray>& sensor_origin) {
  Reading reading(pathOf(path));
  if (!config.is_none()) reading.useConfig(pathOf(config));
  if (resolution) reading.useResolution(*resolution);
  if (sensor_origin) reading.useSensorOrigin(*sensor_origin);
  return reading.run([](const std::string& p, const mrpt::fusion::BuildParams& params) {
    const CMetricMap::Ptr map = mrpt::fusion::loadAnyMap(p, params);
    return withPath(p, [&] { return Map::from(map, Origin::of(p)); });
  });
}

py::dict loadMission(const py::object& path) {
  Reading reading(pathOf(path));
  const auto sent = reading.run([](const std::string& p, const mrpt::fusion::BuildParams&) {
    auto maps = mrpt::fusion::loadLocalMaps(p);
    if (maps.empty()) throw std::runtime_error(p + ": is not a mission: it has no maps of robots");
    return maps;
  });
  py::dict robots;
  for (const auto& s : sent) {
    if (!s->map)
      throw std::runtime_error(pathOf(path) + ": the map of " + s->sensorLabel + " is missing");
    robots[py::str(s->sensorLabel)] =
        Map::from(s->map, {s->sensorLabel, {}, {{s->sensorLabel, {}, s->sequence, 0}}, s->pose});
  }
  return robots;
}

/** \exception std::runtime_error If the extension is that of pictures or point clouds. */
void checkExtension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* other : {".jpeg", ".jpg", ".las", ".laz", ".obj", ".pcd", ".pgm", ".ply", ".png",
                            ".stl", ".xyz", ".yaml"})
    if (extension == other)
      throw std::runtime_error(path + ": a map cannot be written as " + extension +
                               ": use .ot, .bt or .gridmap");
}

void save(const Map& map, const py::object& path) {
  const std::string p = pathOf(path);
  checkExtension(p);
  const py::gil_scoped_release release;
  mrpt::fusion::saveMap(map.metricMap(), p);
}

std::shared_ptr<Map> fromBytes(const py::buffer& data, double resolution) {
  // Bytes stay as they are. All else may change in another thread, and is copied.
  const auto bytes = py::reinterpret_steal<py::bytes>(PyBytes_FromObject(data.ptr()));
  if (!bytes) throw py::error_already_set();
  const auto view = static_cast<std::string_view>(bytes);
  const py::gil_scoped_release release;
  auto map = std::make_shared<CProbOctoMap>();
  map->loadFromOcTreeBytes(view, resolution);
  return std::make_shared<Map>(std::move(map), Origin());
}

py::bytes toBytes(const Map& map, const std::string& format) {
  if (format != "ot" && format != "bt") throw py::value_error("the format is 'ot' or 'bt'");
  std::string bytes;
  {
    const py::gil_scoped_release release;
    bytes = format == "ot" ? map.whole().toOtBytes() : map.whole().toBtBytes();
  }
  return bytes;
}

/** State of a pickle: the object as MRPT serializes it, with sources and sensor model. */
py::tuple toPickle(const Map& map) {
  std::vector<uint8_t> bytes;
  mrpt::serialization::ObjectToOctetVector(&map.metricMap(), bytes);
  return py::make_tuple(py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
                        py::bytes(map.origin().path));
}

std::shared_ptr<Map> fromPickle(const py::tuple& state) {
  const auto view = static_cast<std::string_view>(state[0].cast<py::bytes>());
  mrpt::serialization::CSerializable::Ptr object;
  mrpt::serialization::OctetVectorToObject({view.begin(), view.end()}, object);
  const auto map = std::dynamic_pointer_cast<const CMetricMap>(object);
  if (!map) throw std::runtime_error("the pickle holds no map");
  auto path = state[1].cast<std::string>();
  return Map::from(map, path.empty() ? Origin() : Origin::of(path));
}

}  // namespace

MapPtr mapOf(const py::object& map) {
  if (py::isinstance<Map>(map)) return map.cast<std::shared_ptr<Map>>();
  return load(map, py::none(), {}, {});
}

void bindFiles(py::module_& m) {
  m.def("load", &load, py::arg("path"), py::arg("config") = py::none(), py::kw_only(),
        py::arg("resolution") = py::none(), py::arg("sensor_origin") = py::none(),
        R"(load(path, config=None, *, resolution=None, sensor_origin=None) -> Map

Load the map of a file of any kind: .ot, .bt, a map of MRPT, a point cloud (.pcd, .ply), or a recording
(.rawlog, .simplemap), from which a map is built. config is the path of an .ini file that defines the
map of a recording, as for map-fusion --config. resolution and sensor_origin are for point clouds; other
files do not use them. resolution: voxel size, m (default 0.1). sensor_origin: position of the sensor in
the frame of the points, m: the space between the sensor and the points becomes free. Without
sensor_origin, the file may state the position; otherwise the map has no free space. Differences
between the file and the map are warnings.

>>> mf.load('a.ot').resolution
0.1
)");
  m.def("load_mission", &loadMission, py::arg("path"),
        R"(load_mission(path) -> dict

Load the latest map of each robot of a mission: a rawlog that map-fusion pack writes, for example.
The keys are the names of the robots.
)");
  py::class_<Map, std::shared_ptr<Map>> map{py::object(m.attr("Map"))};
  map.def("save", &save, py::arg("path"),
          R"(save(path) -> None

Save the map. The extension decides: .ot (all probabilities), .bt (occupied or free), otherwise an
object of MRPT, for which .gridmap is usual. Pictures and point clouds (.png, .ply, ...) are an Error.
Writes the whole file or nothing.

>>> mf.load('a.ot').save('copy.ot')
>>> open('copy.ot', 'rb').read() == open('a.ot', 'rb').read()
True
)");
  map.def_static("from_bytes", &fromBytes, py::arg("data"), py::arg("resolution") = 0.0,
                 R"(from_bytes(data, resolution=0) -> Map

Return the map of the contents of a .ot or .bt file: bytes, bytearray or memoryview. For data without a header, as the data of
octomap_msgs/Octomap, resolution is the voxel size, m.

>>> mf.Map.from_bytes(open('a.ot', 'rb').read()).resolution
0.1
)");
  map.def("to_bytes", &toBytes, py::arg("format") = "ot",
          R"(to_bytes(format='ot') -> bytes

Return the contents of a .ot file (all probabilities) or of a .bt file (occupied or free).

>>> mf.load('a.ot').to_bytes() == open('a.ot', 'rb').read()
True
)");
  map.def(py::pickle(&toPickle, &fromPickle));
}

}  // namespace mrpt_fusion_python
