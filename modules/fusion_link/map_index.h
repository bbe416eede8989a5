// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "fusion_link/map_blocks.h"

/** \file
 * The list of the blocks of a map, by which a receiver knows what is missing. */

namespace mrpt::fusion {

/** Largest version. A robot that has lost its versions can continue above those that other robots
 * have, without an overflow. */
constexpr uint64_t kMostVersion = uint64_t{1} << 62U;

/** One version of a map without the bytes of its blocks. */
struct MapIndex {
  uint64_t version = 0;                  ///< Version of the map, at least 1
  Trunk trunk;                           ///< What is not in the blocks
  std::map<BlockCode, uint64_t> blocks;  ///< Version of each block, at most that of the map
  uint64_t hash = 0;                     ///< hashOf() of all blocks
};

/** Returns a hash of the bytes of blocks. It is not cryptographic. */
uint64_t hashOf(const std::map<BlockCode, BlockBytes>& blocks);

/** Returns a packed index. */
std::string toBytes(const MapIndex& index);
/** Inverts toBytes().
 * \exception std::runtime_error If the data is damaged, a number is out of its range, or a block
 * lies in another block. */
MapIndex indexOf(std::string_view bytes);

}  // namespace mrpt::fusion
