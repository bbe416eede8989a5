// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads the maps of a run. */

#include "inputs.h"

#include <mrpt/fusion/voxels.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_base/file_kind.h"
#include "fusion_base/file_names.h"
#include "fusion_base/files.h"
#include "fusion_octree/files.h"
#include "fusion_octree/point_clouds/cloud_map.h"
#include "pose.h"

namespace fs = std::filesystem;
using mrpt::fusion::EdgeVoxels;

namespace map_fusion {

namespace {

/** Returns how the arguments turn point clouds into maps. */
mrpt::fusion::CloudParams cloudParamsOf(const Arguments& args) {
  mrpt::fusion::CloudParams params;
  if (args.resolution > 0) params.resolution = args.resolution;
  if (!args.sensor_origin.empty()) {
    const auto p = parsePoint(args.sensor_origin);
    params.sensor_origin.emplace(static_cast<float>(p.x), static_cast<float>(p.y),
                                 static_cast<float>(p.z));
  }
  return params;
}

/** Loads a map of octomap or a point cloud. Without octree if the file is of another kind. */
LoadedMap loadOctomapFile(const RunContext& run, const std::string& path) {
  using mrpt::fusion::readFileBytes;
  const InputKind kind = inputKindOf(run, path);
  LoadedMap map;
  mrpt::fusion::withPath(path, [&] {
    if (kind == InputKind::OcTree)
      map.octree = mrpt::fusion::parseOcTreeFile(readFileBytes(path), &map.notes);
    else if (kind == InputKind::PointCloud)
      map.octree =
          mrpt::fusion::parseCloudMap(readFileBytes(path), cloudParamsOf(run.args), &map.notes);
    else if (kind == InputKind::RawNodes)
      map.octree =
          mrpt::fusion::parseRawOcTree(readFileBytes(path), run.args.resolution, &map.notes);
  });
  return map;
}

/** Records which options had an effect on a map that was loaded. */
void recordOptions(RunContext& run, const std::string& path) {
  if (run.args.resolution <= 0 && run.args.sensor_origin.empty()) return;
  const InputKind kind = inputKindOf(run, path);
  run.uses_sensor_origin |= kind == InputKind::PointCloud;
  run.uses_resolution |= kind == InputKind::PointCloud || kind == InputKind::RawNodes;
}

/** Returns the name of a map as a source: the name of its file, unlike those of the other maps. */
std::string sourceNameOf(const RunContext& run, const std::string& path) {
  const auto& paths = run.args.maps;
  const auto index = std::find(paths.begin(), paths.end(), path) - paths.begin();
  return mrpt::fusion::namesOf(paths).at(static_cast<size_t>(index));
}

/** Reports on a map that was loaded. A map without sources is a source named by its file. */
void report(RunContext& run, const std::string& path, LoadedMap& map,
            mrpt::fusion::MapReport on_map) {
  if (run.args.command != "info" && on_map.statistics.occupied == 0)
    throw std::runtime_error(path + ": the map has no occupied voxel");
  for (const auto& note : map.notes) run.note(path + ": " + note);
  recordOptions(run, path);
  run.progress.clear();
  run.report.maps.push_back(std::move(on_map));
  run.report.maps.back().sources = map.sources;
  if (map.sources.empty()) map.sources = {{{}, sourceNameOf(run, path), 0, 0}};
}

}  // namespace

std::optional<ReadOctree> readAhead(const RunContext& run, const std::string& role,
                                    const std::string& path) {
  try {
    if (!fs::is_regular_file(path)) return {};
    ReadOctree read{loadOctomapFile(run, path), {}};
    if (!read.map.octree) return {};
    read.report = mrpt::fusion::reportOn(role, path, *read.map.octree);
    return read;
  } catch (const std::exception&) {
    return {};  // loadMap() reads the file again, and says what is wrong
  }
}

LoadedMap loadMap(RunContext& run, const std::string& role, const std::string& path,
                  std::optional<ReadOctree> ahead) {
  run.progress.show("loading " + path);
  if (!ahead) {
    ahead.emplace();
    ahead->map = loadOctomapFile(run, path);
    if (!ahead->map.octree) ahead->map = mrptMaps().load(path, run.mapDefinition());
    ahead->report = mrpt::fusion::reportOn(role, path, *ahead->map.octree);
  }
  LoadedMap map = std::move(ahead->map);
  report(run, path, map, std::move(ahead->report));
  run.endStep("load");
  return map;
}

InputKind inputKindOf(const RunContext& run, const std::string& path) {
  return mrpt::fusion::withPath(path, [&] {
    const std::string beginning = mrpt::fusion::beginningOf(path);
    if (mrpt::fusion::isOcTreeFile(beginning)) return InputKind::OcTree;
    if (mrpt::fusion::isPointCloudFile(beginning)) return InputKind::PointCloud;
    const std::string foreign = mrpt::fusion::foreignKindOf(beginning);
    if (!foreign.empty()) throw std::runtime_error(foreign);
    if (mrpt::fusion::beginsWithObject(beginning)) return InputKind::Mrpt;
    if (run.args.resolution > 0) return InputKind::RawNodes;
    throw std::runtime_error(
        "not a map, simplemap or rawlog file, or truncated. The data of octomap_msgs/Octomap "
        "without a header needs --resolution");
  });
}

std::vector<Robot> loadFileOfRobots(RunContext& run, const std::string& role,
                                    const std::string& path) {
  run.progress.show("loading " + path);
  FileContents contents;
  if (LoadedMap map = loadOctomapFile(run, path); map.octree)
    contents.map = std::move(map);
  else
    contents = mrptMaps().loadContents(path, run.mapDefinition());
  for (const Robot& robot : contents.robots) {
    run.report.maps.push_back(mrpt::fusion::reportOn(robot.name, path, *robot.map.octree));
    run.report.maps.back().sources = robot.map.sources;
  }
  if (contents.map) {
    report(run, path, *contents.map, mrpt::fusion::reportOn(role, path, *contents.map->octree));
    Robot& robot = contents.robots.emplace_back();
    robot.name = role;
    robot.map = std::move(*contents.map);
    run.endStep("load");
  }
  return contents.robots;
}

std::vector<std::string> distinctFiles(const std::vector<std::string>& paths,
                                       std::vector<std::string>* repeated) {
  std::vector<std::string> distinct;
  for (const std::string& path : paths) {
    const bool is_known = std::any_of(distinct.begin(), distinct.end(), [&](const auto& other) {
      return mrpt::fusion::isSameFile(path, other);
    });
    if (!is_known)
      distinct.push_back(path);
    else if (repeated)
      repeated->push_back(path);
  }
  return distinct;
}

std::vector<Robot> loadRobots(RunContext& run) {
  std::vector<Robot> robots;
  std::vector<std::string> repeated;
  const std::vector<std::string> paths = distinctFiles(run.args.maps, &repeated);
  for (const std::string& path : repeated) run.note(path + ": is given twice, and counts once");
  const std::vector<std::string> names = mrpt::fusion::namesOf(paths);
  for (size_t i = 0; i < names.size(); i++) {
    const std::string& path = paths[i];
    auto of_file = loadFileOfRobots(run, names[i], path);
    for (Robot& robot : of_file) {
      const bool twice = std::any_of(robots.begin(), robots.end(),
                                     [&](const auto& other) { return other.name == robot.name; });
      if (twice)
        throw std::runtime_error(path + ": there are two maps of '" + robot.name +
                                 "': a mission that is given twice, or robots of one name");
      if (run.args.edges_only)
        robot.map = mrpt::fusion::withPath(path, [&]() -> LoadedMap {
          return {
              nullptr, std::make_shared<const EdgeVoxels>(edgesOf(run, robot.map)), nullptr, {}};
        });
      robots.push_back(robot);
    }
  }
  run.endStep("load");
  run.progress.clear();
  return robots;
}

EdgeVoxels edgesOf(const RunContext& run, const LoadedMap& map) {
  return extractEdges(mrpt::fusion::extractOccupiedVoxels(map.wholeMap()),
                      run.options.features.edges);
}

}  // namespace map_fusion
