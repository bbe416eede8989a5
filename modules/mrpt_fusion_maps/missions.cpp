// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads and writes missions: rawlogs with the maps of several robots. */

#include "mrpt_fusion_maps/missions.h"

#include <mrpt/fusion/map_files.h>

#include <memory>
#include <stdexcept>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_base/printable.h"
#include "fusion_octree/files.h"
#include "mrpt_fusion_maps/map_diffs.h"
#include "mrpt_fusion_maps/recordings/object_reader.h"
#include "mrpt_fusion_maps/recordings/object_writer.h"

using mrpt::obs::CObservationLocalMap;
using mrpt::obs::CObservationMapDiff;
using mrpt::serialization::CSerializable;

namespace mrpt::fusion {
namespace {

/** Returns whether a map of a robot replaces another map of this robot. A whole map replaces edges.
 * Of two maps of the same kind, the later map replaces the earlier map. */
bool replaces(const CObservationLocalMap& map, const CObservationLocalMap& other) {
  const auto isWhole = [](const CObservationLocalMap& o) {
    return o.map && asProbOctoMap(*o.map) != nullptr;
  };
  const bool whole = isWhole(map);
  return whole != isWhole(other) ? whole : map.sequence >= other.sequence;
}

/** Returns the map that the diffs of a robot give. */
CObservationLocalMap::Ptr mapOf(const MapReplica& diffs) {
  if (diffs.completeVersion() == 0)
    throw std::runtime_error("the map of " + printable(diffs.source().robot) +
                             " is not whole: " + std::to_string(diffs.missing().size()) +
                             " of its " + std::to_string(diffs.index()->blocks.size()) +
                             " blocks are missing, which earlier diffs had");
  auto map = std::make_shared<mrpt::maps::CProbOctoMap>(joinBlocks(*diffs.blocks()));
  map->setSources({{diffs.source().robot, {}, diffs.completeVersion(), 0}});
  auto result = CObservationLocalMap::Create();
  result->sensorLabel = diffs.source().robot;
  result->sequence = diffs.completeVersion();
  result->map = std::move(map);
  return result;
}

}  // namespace

LatestMaps::Robot& LatestMaps::robot(const std::string& name) {
  for (Robot& known : robots_)
    if (known.name == name) return known;
  return robots_.emplace_back(Robot{name, nullptr, {}, {}});
}

void LatestMaps::add(const CSerializable::Ptr& object) {
  if (const auto map = std::dynamic_pointer_cast<CObservationLocalMap>(object)) {
    Robot& sender = robot(map->sensorLabel);
    if (!sender.map || replaces(*map, *sender.map)) sender.map = map;
    count_++;
  } else if (const auto diff = std::dynamic_pointer_cast<CObservationMapDiff>(object)) {
    Robot& sender = robot(diff->sensorLabel);
    if (!sender.diffs) sender.diffs.emplace(emptyReplicaOf(*diff));
    addDiff(*diff, *sender.diffs);
    sender.last_diff = diff->timestamp;
    count_++;
  }
}

std::vector<CObservationLocalMap::Ptr> LatestMaps::maps() const {
  std::vector<CObservationLocalMap::Ptr> maps;
  for (const Robot& sender : robots_) {
    CObservationLocalMap::Ptr map = sender.map;
    if (sender.diffs) {
      const auto of_diffs = mapOf(*sender.diffs);
      of_diffs->timestamp = sender.last_diff;
      if (!map || replaces(*of_diffs, *map)) map = of_diffs;
    }
    maps.push_back(std::move(map));
  }
  return maps;
}

mrpt::maps::CMetricMap::Ptr onlyMapOf(const std::vector<CObservationLocalMap::Ptr>& robots) {
  if (robots.size() > 1)
    throw std::runtime_error("holds the maps of " + std::to_string(robots.size()) +
                             " robots, not one map");
  if (!robots.front()->map) throw std::runtime_error("the robot's map is missing in it");
  return robots.front()->map;
}

std::vector<CObservationLocalMap::Ptr> loadLocalMaps(const std::string& path) {
  return withPath(path, [&]() -> std::vector<CObservationLocalMap::Ptr> {
    if (isOcTreeFile(beginningOf(path))) return {};
    ObjectReader reader(path);
    auto object = reader.next();
    if (!isRecording(*object)) return {};
    LatestMaps latest;
    for (; object; object = reader.next()) latest.add(object);
    return latest.maps();
  });
}

void saveLocalMaps(const std::vector<CObservationLocalMap::Ptr>& maps, const std::string& path) {
  std::vector<const CSerializable*> objects;
  objects.reserve(maps.size());
  for (const auto& map : maps) objects.push_back(map.get());
  saveObjects(objects, path);
}

}  // namespace mrpt::fusion
