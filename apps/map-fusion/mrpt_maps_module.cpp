// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The module with all functions that need MRPT's map classes. */

#include <mrpt/fusion/export.h>
#include <mrpt/fusion/fusion_scene.h>
#include <mrpt/fusion/map_files.h>
#include <mrpt/graphs/CNetworkOfPoses.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/serialization/CArchive.h>

#include <filesystem>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "mrpt_fusion_maps/map_diffs.h"
#include "mrpt_maps.h"
#include "silence.h"

using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationLocalMap;

namespace map_fusion {

namespace {

/** Returns a map to work on. \exception std::runtime_error If it is not a 3-D occupancy map. */
LoadedMap workable(const CMetricMap::Ptr& map) {
  if (const auto* edges = dynamic_cast<const CEdgeVoxelMap*>(map.get()))
    return {std::make_shared<const octomap::OcTree>(edges->asOcTree()),
            {map, &edges->edges()},
            map,
            {}};
  const auto octomap = mrpt::fusion::asProbOctoMap(CMetricMap::ConstPtr(map));
  if (!octomap)
    throw std::runtime_error(std::string("a ") + map->GetRuntimeClass()->className +
                             " is not, and holds no, 3-D occupancy map");
  return {{octomap, &octomap->octree()},
          nullptr,
          std::const_pointer_cast<CProbOctoMap>(octomap),
          {},
          octomap->sources()};
}

/** Returns the map as it was read, or else as one of our classes. */
CMetricMap::Ptr mrptMapOf(const LoadedMap& map) {
  if (map.mrpt) return map.mrpt;
  if (map.edges) return std::make_shared<CEdgeVoxelMap>(*map.edges);
  auto octomap = std::make_shared<CProbOctoMap>(*map.octree);
  octomap->setSources(map.sources);
  return octomap;
}

/** \param[out] notes Receives the notes. It must outlive the result. */
mrpt::fusion::BuildParams toParams(const MapDefinition& definition,
                                   std::vector<std::string>& notes) {
  return {definition.config, definition.section, definition.progress,
          [&notes](const std::string& note) { notes.push_back(note); }};
}

class RawlogRecorder : public MissionRecorder {
 public:
  explicit RawlogRecorder(const std::string& path) : file_(path) {}
  void append(const mrpt::fusion::MapDiff& diff) override {
    mrpt::io::CMemoryStream memory;
    mrpt::serialization::archiveFrom(memory) << *mrpt::fusion::observationOf(diff);
    file_.append({static_cast<const char*>(memory.getRawBufferData()),
                  static_cast<size_t>(memory.getTotalBytesCount())});
  }

 private:
  mrpt::fusion::FileAppender file_;
};

class MapsOfModule : public MrptMaps {
 public:
  LoadedMap load(const std::string& path, const MapDefinition& definition) const override {
    const SilentErrors silent;
    std::vector<std::string> notes;
    const CMetricMap::Ptr map = mrpt::fusion::loadAnyMap(path, toParams(definition, notes));
    LoadedMap loaded = mrpt::fusion::withPath(path, [&] { return workable(map); });
    loaded.notes = notes;
    return loaded;
  }

  FileContents loadContents(const std::string& path,
                            const MapDefinition& definition) const override {
    const SilentErrors silent;
    std::vector<std::string> notes;
    const auto read = mrpt::fusion::loadContents(path, toParams(definition, notes));
    FileContents contents;
    if (read.map) {
      contents.map = mrpt::fusion::withPath(path, [&] { return workable(read.map); });
      contents.map->notes = notes;
    }
    for (const auto& sent : read.robots) {
      if (!sent->map)
        throw std::runtime_error(path + ": the map of " + sent->sensorLabel + " is missing");
      Robot& robot = contents.robots.emplace_back();
      robot.name = sent->sensorLabel;
      robot.map = mrpt::fusion::withPath(path, [&] { return workable(sent->map); });
      robot.map.mrpt = sent->map;
      if (robot.map.sources.empty())
        robot.map.sources = {{sent->sensorLabel, {}, sent->sequence, 0}};
      robot.pose = sent->pose;
      robot.sent = sent;
    }
    return contents;
  }

  void saveMission(const std::vector<Robot>& robots, bool smallest,
                   const std::string& path) const override {
    std::vector<CObservationLocalMap::Ptr> observations;
    for (const Robot& robot : robots) {
      auto o =
          robot.sent ? CObservationLocalMap::Create(*robot.sent) : CObservationLocalMap::Create();
      o->sensorLabel = robot.name;
      o->map = mrptMapOf(robot.map);
      o->smallest = o->smallest || smallest;
      observations.push_back(o);
    }
    const SilentErrors silent;
    mrpt::fusion::saveLocalMaps(observations, path);
  }

  std::unique_ptr<MissionRecorder> recordMission(const std::string& path) const override {
    const SilentErrors silent;
    std::error_code none;
    if (std::filesystem::file_size(path, none) > 0 && !none) {
      const bool is_mission = !mrpt::fusion::loadLocalMaps(path).empty();
      if (!is_mission) throw std::runtime_error(path + ": is no mission that can be continued");
    }
    return std::make_unique<RawlogRecorder>(path);
  }

  BuiltMap build(const std::string& recording, const MapDefinition& definition) const override {
    const SilentErrors silent;
    LoadedMap map;
    const auto built = mrpt::fusion::buildMap(recording, toParams(definition, map.notes));
    map.mrpt = built.map;
    if (const auto octomap = mrpt::fusion::asProbOctoMap(CMetricMap::ConstPtr(built.map)))
      map.octree = {octomap, &octomap->octree()};
    mrpt::fusion::ObservationCount observations{built.inserted, built.ignored, {}};
    for (const auto& l : built.left_out)
      observations.left_out.push_back({l.kind, l.reason, l.count});
    return {map, observations};
  }

  size_t joinRecordings(const std::vector<PlacedRecording>& recordings,
                        const std::string& path) const override {
    std::vector<mrpt::fusion::PlacedSimpleMap> maps;
    for (const auto& r : recordings) maps.push_back({r.path, r.pose});
    const SilentErrors silent;
    return mrpt::fusion::joinSimpleMaps(maps, path);
  }

  void save(const LoadedMap& map, const std::string& path) const override {
    const SilentErrors silent;
    mrpt::fusion::saveMap(*mrptMapOf(map), path);
  }

  void saveSlice(const mrpt::fusion::MapSlice& slice, const std::string& path) const override {
    const SilentErrors silent;
    const auto end = [&](double low, size_t cells) {
      return low + static_cast<double>(cells) * slice.resolution;
    };
    mrpt::maps::COccupancyGridMap2D grid;
    grid.setSize(static_cast<float>(slice.low_x), static_cast<float>(end(slice.low_x, slice.width)),
                 static_cast<float>(slice.low_y),
                 static_cast<float>(end(slice.low_y, slice.height)),
                 static_cast<float>(slice.resolution));
    for (size_t i = 0; i < slice.log_odds.size(); i++) {
      if (slice.log_odds[i] == mrpt::fusion::MapSlice::kUnknown) continue;
      const double is_free = 1 - octomap::probability(slice.log_odds[i]);
      grid.setCell(static_cast<int>(i % slice.width), static_cast<int>(i / slice.width),
                   static_cast<float>(is_free));
    }
    mrpt::fusion::saveObject(grid, path);
  }

  std::string toGraphText(const mrpt::fusion::PoseGraph& poses) const override {
    mrpt::graphs::CNetworkOfPoses3DInf graph;
    for (const auto& v : poses.vertices) graph.nodes[v.id] = mrpt::fusion::toPose(v.pose);
    if (!poses.vertices.empty()) graph.root = poses.vertices.front().id;
    for (const auto& e : poses.edges) {
      const auto covariance = mrpt::fusion::toYawPitchRollCovariance(e.covariance, e.T_a_b);
      graph.insertEdgeAtEnd(
          e.a, e.b,
          mrpt::poses::CPose3DPDFGaussianInf(
              mrpt::fusion::toPose(e.T_a_b),
              mrpt::math::CMatrixDouble66(mrpt::fusion::informationOf(covariance))));
    }
    std::ostringstream text;
    text << std::setprecision(std::numeric_limits<double>::max_digits10);
    graph.writeAsText(text);
    return text.str();
  }

  void removeTemporaryFiles() const noexcept override { mrpt::fusion::removeTemporaryMapFiles(); }

  void drawScene(const SceneContents& c, const std::string& path) const override {
    const mrpt::fusion::FusionView view{
        c.a, c.b, c.pose, c.pairs, c.edges_a, c.edges_b, c.inlier_mahalanobis, c.fused};
    mrpt::fusion::saveObject(*mrpt::fusion::drawFusion(view), path);
  }
};

}  // namespace

}  // namespace map_fusion

/** The function that mrptMaps() calls. */
extern "C" MRPT_FUSION_API const map_fusion::MrptMaps* mrptMapsOfModule() {
  static const map_fusion::MapsOfModule maps;
  return &maps;
}
