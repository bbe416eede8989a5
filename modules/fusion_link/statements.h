// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "fusion_link/map_blocks.h"
#include "fusion_team/link/link.h"

/** \file
 * What robots say about the maps of others: what they have, and what they want. */

namespace mrpt::fusion {

/** The versions that a robot has of a map. What is complete is in the robot's journal. */
struct HeldVersion {
  SourceName source;      ///< The map
  uint64_t complete = 0;  ///< Version that the robot has as a whole; 0: none
  uint64_t highest = 0;   ///< Highest version of any sample that the robot has
};

/** The blocks of a map that a robot wants first, the most wanted block first. */
struct WantedBlocks {
  SourceName source;              ///< The map
  std::vector<BlockCode> blocks;  ///< Numbers of the blocks
};

/** Returns the value of a sample of SampleKind::Have. What does not fit is left out. */
std::string toBytes(const std::vector<HeldVersion>& held);
/** Inverts toBytes(). \exception std::runtime_error If the data is damaged. */
std::vector<HeldVersion> heldVersionsOf(std::string_view bytes);

/** Returns the value of a sample of SampleKind::Want. What does not fit is left out. */
std::string toBytes(const std::vector<WantedBlocks>& wanted);
/** Inverts toBytes(). \exception std::runtime_error If the data is damaged. */
std::vector<WantedBlocks> wantedBlocksOf(std::string_view bytes);

/** True if a name may be the name of a robot or of a map: at most kMostNameCharacters, none of
 * which controls a terminal. */
bool isName(std::string_view name);

/** Returns all of a sample as bytes, for the journal. */
std::string toBytes(const Sample& sample);
/** Inverts toBytes(). \exception std::runtime_error If the data is damaged. */
Sample sampleOf(std::string_view bytes);

}  // namespace mrpt::fusion
