// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Joins simplemaps. */

#include <mrpt/fusion/map_files.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <memory>
#include <stdexcept>

#include "fusion_base/error_text.h"
#include "mrpt_fusion_maps/recordings/external_files.h"
#include "mrpt_fusion_maps/recordings/external_links.h"
#include "mrpt_fusion_maps/recordings/object_reader.h"

using mrpt::maps::CSimpleMap;
using mrpt::poses::CPose3DPDFGaussian;

namespace mrpt::fusion {
namespace {

std::shared_ptr<CSimpleMap> loadSimpleMap(const std::string& path) {
  auto frames = std::dynamic_pointer_cast<CSimpleMap>(firstObject(path));
  if (!frames) throw std::runtime_error("is not a simplemap");
  for (const auto& frame : *frames)
    if (!frame.pose || !frame.sf)
      throw std::runtime_error("corrupt: a keyframe has no pose or no observations");
  return frames;
}

/** Returns the pose of a key frame in the common frame. A map that is not moved keeps the
 * distribution of its key frames, which may be of any kind. */
mrpt::poses::CPose3DPDF::Ptr moved(const CPose3DPDFGaussian& map,
                                   const mrpt::poses::CPose3DPDF::Ptr& frame) {
  const CPose3DPDFGaussian origin;
  if (map.mean == origin.mean && map.cov == origin.cov) return frame;
  CPose3DPDFGaussian in_map;
  in_map.copyFrom(*frame);
  auto pose = std::make_shared<CPose3DPDFGaussian>(map);
  *pose += in_map;
  return pose;
}

}  // namespace

size_t joinSimpleMaps(const std::vector<PlacedSimpleMap>& maps, const std::string& path) {
  CSimpleMap joined;
  for (const PlacedSimpleMap& map : maps)
    withPath(map.path, [&] {
      const std::string directory = imagesDirectoryOf(map.path);
      const auto frames = loadSimpleMap(map.path);
      for (const auto& frame : *frames) {
        for (const auto& obs : *frame.sf) {
          if (!obs) throw std::runtime_error("corrupt: an object in a frame is not an observation");
          makeExternalNamesAbsolute(*obs, directory);
        }
        joined.insert(moved(map.pose, frame.pose), frame.sf);
      }
    });
  saveObject(joined, path);
  return joined.size();
}

}  // namespace mrpt::fusion
