// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/edge_octree.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/error_text.h>
#include <mrpt/maps/map_files.h>
#include <mrpt/slam/fusion_scene.h>

#include <stdexcept>

#include "mrpt_maps.h"

using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationLocalMap;

namespace {

LoadedMap workable(const CMetricMap::Ptr& map) {
  if (const auto* edges = dynamic_cast<const CEdgeVoxelMap*>(map.get()))
    return {
        std::make_shared<const octomap::OcTree>(edges->asOcTree()), {map, &edges->edges()}, map};
  const auto octomap = mrpt::maps::asProbOctoMap(CMetricMap::ConstPtr(map));
  if (!octomap)
    throw std::runtime_error(std::string("a ") + map->GetRuntimeClass()->className +
                             " is not, and holds no, 3-D occupancy map");
  return {{octomap, &octomap->octree()}, nullptr, std::const_pointer_cast<CProbOctoMap>(octomap)};
}

mrpt::maps::BuildParams paramsOf(const MapDefinition& definition) {
  return {definition.config, definition.section, definition.progress};
}

/** What a robot sends: what it had sent, but for a map that is another now. */
CObservationLocalMap::Ptr observationOf(const Robot& robot) {
  auto o = robot.sent ? CObservationLocalMap::Create(*robot.sent) : CObservationLocalMap::Create();
  o->sensorLabel = robot.name;
  if (robot.map.mrpt)
    o->map = robot.map.mrpt;
  else if (robot.map.edges)
    o->map = std::make_shared<CEdgeVoxelMap>(*robot.map.edges);
  else
    o->map = std::make_shared<CProbOctoMap>(*robot.map.octree);
  return o;
}

class MapsOfModule : public MrptMaps {
 public:
  LoadedMap load(const std::string& path, const MapDefinition& definition) const override {
    const CMetricMap::Ptr map = mrpt::maps::loadAnyMap(path, paramsOf(definition));
    return mrpt::maps::withPath(path, [&] { return workable(map); });
  }

  std::vector<Robot> loadMission(const std::string& path) const override {
    std::vector<Robot> robots;
    for (const auto& sent : mrpt::maps::loadLocalMaps(path)) {
      if (!sent->map)
        throw std::runtime_error(path + ": the map of " + sent->sensorLabel + " is missing");
      Robot& robot = robots.emplace_back();
      robot.name = sent->sensorLabel;
      robot.map = mrpt::maps::withPath(path, [&] { return workable(sent->map); });
      robot.map.mrpt = sent->map;
      robot.pose = sent->pose;
      robot.sent = sent;
    }
    return robots;
  }

  void saveMission(const std::vector<Robot>& robots, const std::string& path) const override {
    std::vector<CObservationLocalMap::Ptr> observations;
    for (const Robot& robot : robots) observations.push_back(observationOf(robot));
    mrpt::maps::saveLocalMaps(observations, path);
  }

  BuiltFile build(const std::string& recording, const MapDefinition& definition,
                  const std::string& path) const override {
    const auto built = mrpt::maps::buildMap(recording, paramsOf(definition));
    mrpt::maps::saveMap(*built.map, path);
    LoadedMap map;
    if (const auto octomap = mrpt::maps::asProbOctoMap(CMetricMap::ConstPtr(built.map)))
      map.octree = {octomap, &octomap->octree()};
    return {map, built.inserted, built.ignored};
  }

  void save(const octomap::OcTree& map, const std::string& path) const override {
    mrpt::maps::saveMap(CProbOctoMap(map), path);
  }
  void save(const mrpt::fusion::EdgeVoxels& edges, const std::string& path) const override {
    mrpt::maps::saveMap(CEdgeVoxelMap(edges), path);
  }

  void drawScene(const SceneView& view, const std::string& path) const override {
    const auto scene =
        mrpt::slam::drawFusion({*view.a.octree, *view.b.octree, view.pose, view.pairs, view.edges_a,
                                view.edges_b, view.inlier_mahalanobis, view.fused});
    mrpt::maps::saveObject(*scene, path);
  }
  void drawPicture(const mrpt::fusion::OccupiedVoxels& a, const mrpt::fusion::OccupiedVoxels& b,
                   const std::vector<TopViewPanel>& panels,
                   const std::string& path) const override {
    drawTopView(a, b, panels, path);
  }
};

}  // namespace

/** What mrptMaps() looks for. */
extern "C" const MrptMaps* mrptMapsOfModule() {
  static const MapsOfModule maps;
  return &maps;
}
