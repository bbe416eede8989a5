// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fusion_link/map_replica.h"

/** \file
 * What has changed between two versions of a map. */

namespace mrpt::fusion {

/** The blocks of a map that have changed, and the list of all its blocks. */
struct MapDiff {
  /** A block that has changed. */
  struct Block {
    BlockCode code = 0;    ///< Its cube
    uint64_t version = 0;  ///< Version of the map at which it changed last
    BlockBytes bytes;      ///< Compressed nodes
  };

  SourceName source;          ///< Name of the map
  uint64_t version = 0;       ///< Version of the map
  std::string index;          ///< Packed MapIndex
  std::vector<Block> blocks;  ///< Blocks that have changed
};

/** Returns what has changed in a map after a version. Nothing if the map is not complete, or if it
 * has this version. \param[in] version 0: all blocks are returned. */
std::optional<MapDiff> diffSince(const MapReplica& map, uint64_t version);

}  // namespace mrpt::fusion
