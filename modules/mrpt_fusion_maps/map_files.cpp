// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads maps from files of any kind, and saves them. */

#include <mrpt/fusion/map_files.h>
#include <mrpt/system/filesystem.h>

#include <stdexcept>
#include <utility>
#include <vector>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_octree/files.h"
#include "fusion_octree/point_clouds/cloud_map.h"
#include "mrpt_fusion_maps/recordings/map_builder.h"
#include "mrpt_fusion_maps/recordings/object_reader.h"
#include "mrpt_fusion_maps/recordings/recording.h"

using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;

namespace mrpt::fusion {

namespace {

/** Returns the map of an octree file or a point cloud. Null if the file is of another kind. */
std::unique_ptr<octomap::OcTree> loadOctree(const std::string& path, const BuildParams& params) {
  const std::string beginning = beginningOf(path);
  std::vector<std::string> notes;
  std::unique_ptr<octomap::OcTree> octree;
  if (isOcTreeFile(beginning)) {
    octree = parseOcTreeFile(readFileBytes(path), &notes);
  } else if (isPointCloudFile(beginning)) {
    CloudParams cloud{params.cloud_resolution, {}};
    if (const auto& p = params.cloud_sensor_origin)
      cloud.sensor_origin.emplace(static_cast<float>(p->x), static_cast<float>(p->y),
                                  static_cast<float>(p->z));
    octree = parseCloudMap(readFileBytes(path), cloud, &notes);
  }
  if (params.note)
    for (const auto& note : notes) params.note(note);
  return octree;
}

}  // namespace

FileContents loadContents(const std::string& path, const BuildParams& params) {
  return withPath(path, [&]() -> FileContents {
    if (auto octree = loadOctree(path, params))
      return {{}, std::make_shared<CProbOctoMap>(std::move(octree))};

    ObjectReader reader(path);
    const auto first = reader.next();
    if (isRecording(*first)) {
      Recording recording(path, reader, first);
      if (recording.latestMaps().count() > 0) return {recording.latestMaps().maps(), nullptr};
      return {{}, buildFrom(path, *first, &recording, params).map};
    }
    auto map = std::dynamic_pointer_cast<CMetricMap>(first);
    if (!map)
      throw std::runtime_error(std::string("a ") + first->GetRuntimeClass()->className +
                               " is no map");
    return {{}, map};
  });
}

CMetricMap::Ptr loadAnyMap(const std::string& path, const BuildParams& params) {
  const FileContents contents = loadContents(path, params);
  if (contents.map) return contents.map;
  return withPath(path, [&] { return onlyMapOf(contents.robots); });
}

std::shared_ptr<const CProbOctoMap> loadMap(const std::string& path, const BuildParams& params) {
  const CMetricMap::Ptr map = loadAnyMap(path, params);
  auto octomap = asProbOctoMap(CMetricMap::ConstPtr(map));
  if (!octomap)
    throw std::runtime_error(path + ": a " + map->GetRuntimeClass()->className +
                             " is not, and holds no, 3-D occupancy map");
  return octomap;
}

void removeTemporaryMapFiles() noexcept { removeTemporaryFiles(); }

void saveMap(const CMetricMap& map, const std::string& path) {
  const std::string extension = mrpt::system::extractFileExtension(path);
  if (extension == "ot" || extension == "bt") {
    const auto octomap = asProbOctoMap(map);
    if (!octomap)
      throw std::runtime_error(path + ": a " + map.GetRuntimeClass()->className +
                               " cannot be saved as an octree");
    octomap->saveToOcTreeFile(path);
  } else {
    saveObject(map, path);
  }
}

}  // namespace mrpt::fusion
