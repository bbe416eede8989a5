// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads and writes missions: rawlogs with the maps of several robots. */

#include "mrpt_fusion_maps/missions.h"

#include <mrpt/fusion/map_files.h>

#include <algorithm>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_octree/files.h"
#include "mrpt_fusion_maps/recordings/object_reader.h"
#include "mrpt_fusion_maps/recordings/object_writer.h"

using mrpt::obs::CObservationLocalMap;
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

}  // namespace

void addToLatest(CObservationLocalMap::Ptr map, std::vector<CObservationLocalMap::Ptr>& latest) {
  const auto known = std::find_if(latest.begin(), latest.end(), [&](const auto& other) {
    return other->sensorLabel == map->sensorLabel;
  });
  if (known == latest.end())
    latest.push_back(std::move(map));
  else if (replaces(*map, **known))
    *known = std::move(map);
}

std::vector<CObservationLocalMap::Ptr> loadLocalMaps(const std::string& path) {
  return withPath(path, [&]() -> std::vector<CObservationLocalMap::Ptr> {
    std::vector<CObservationLocalMap::Ptr> latest;
    if (isOcTreeFile(beginningOf(path))) return latest;
    ObjectReader reader(path);
    auto object = reader.next();
    if (!isRecording(*object)) return latest;
    for (; object; object = reader.next())
      if (auto map = std::dynamic_pointer_cast<CObservationLocalMap>(object))
        addToLatest(std::move(map), latest);
    return latest;
  });
}

void saveLocalMaps(const std::vector<CObservationLocalMap::Ptr>& maps, const std::string& path) {
  std::vector<const CSerializable*> objects;
  objects.reserve(maps.size());
  for (const auto& map : maps) objects.push_back(map.get());
  saveObjects(objects, path);
}

}  // namespace mrpt::fusion
