// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads and writes missions: rawlogs with the maps of several robots. */

#include "mrpt_fusion_maps/missions.h"

#include <mrpt/fusion/map_files.h>

#include <algorithm>

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

std::vector<CObservationLocalMap::Ptr> latestMaps(const std::string& path) {
  std::vector<CObservationLocalMap::Ptr> latest;
  ObjectReader reader(path);
  while (const auto object = reader.next()) {
    const auto map = std::dynamic_pointer_cast<CObservationLocalMap>(object);
    if (!map) continue;
    const auto known = std::find_if(latest.begin(), latest.end(), [&](const auto& other) {
      return other->sensorLabel == map->sensorLabel;
    });
    if (known == latest.end())
      latest.push_back(map);
    else if (replaces(*map, **known))
      *known = map;
  }
  return latest;
}

std::vector<CObservationLocalMap::Ptr> loadLocalMaps(const std::string& path) {
  return withPath(path, [&]() -> std::vector<CObservationLocalMap::Ptr> {
    if (isOcTreeFile(beginningOf(path)) || !isRecording(*firstObject(path))) return {};
    return latestMaps(path);
  });
}

void saveLocalMaps(const std::vector<CObservationLocalMap::Ptr>& maps, const std::string& path) {
  std::vector<const CSerializable*> objects;
  objects.reserve(maps.size());
  for (const auto& map : maps) objects.push_back(map.get());
  saveObjects(objects, path);
}

}  // namespace mrpt::fusion
