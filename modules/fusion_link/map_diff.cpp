// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Finds what has changed between two versions of a map. */
#include "fusion_link/map_diff.h"

#include "fusion_link/map_index.h"

namespace mrpt::fusion {

std::optional<MapDiff> diffSince(const MapReplica& map, uint64_t version) {
  if (map.completeVersion() == 0 || map.completeVersion() == version) return std::nullopt;
  MapDiff diff{map.source(), map.completeVersion(), toBytes(*map.index()), {}};
  const MapBlocks present = *map.blocks();
  for (const auto& [code, changed] : map.index()->blocks)
    if (changed > version) diff.blocks.push_back({code, changed, present.blocks.at(code)});
  return diff;
}

}  // namespace mrpt::fusion
