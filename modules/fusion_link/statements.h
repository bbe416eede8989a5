// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "fusion_link/map_blocks.h"
#include "fusion_team/link/link.h"

/** \file
 * What robots say about the maps of others: what they have, and what they want. */

namespace mrpt::fusion {

/** What a robot has of the map of the robot to which it states this. */
struct Holdings {
  uint64_t complete = 0;  ///< Version that the robot has as a whole, in its journal; 0: none
  uint64_t highest = 0;   ///< Highest version of any sample that the robot has
  /** Number of the session. Not 0 at its begin only: then the marks below are all there are. */
  uint64_t session = 0;
  bool asks = false;         ///< True if the robot does not know yet what the other robot has
  std::set<uint64_t> marks;  ///< Marks of the samples that are newer than the complete version
};

/** Returns a number that stands for the key and the version of a sample of one map. */
uint64_t markOf(const SampleKey& key, uint64_t version);

/** Returns the value of a sample of SampleKind::Have. Marks that do not fit are left out. */
std::string toBytes(const Holdings& holdings);
/** Inverts toBytes(). \exception std::runtime_error If the data is damaged. */
Holdings holdingsOf(std::string_view bytes);

/** The blocks of a map that a robot wants first. */
struct WantedBlocks {
  SourceName source;              ///< The map
  std::vector<BlockCode> blocks;  ///< Numbers of the blocks, the most wanted block first
  bool no_others = false;         ///< True if the robot wants no other blocks for now
};

/** Returns the value of a sample of SampleKind::Want, without the source. What does not fit is left
 * out. */
std::string toBytes(const WantedBlocks& wanted);
/** Inverts toBytes(). \exception std::runtime_error If the data is damaged. */
WantedBlocks wantedBlocksOf(std::string_view bytes);

/** True if a name may be the name of a robot or of a map: at most kMostNameCharacters, none of
 * which controls a terminal. */
bool isName(std::string_view name);

/** Returns all of a sample as bytes, for the journal and for messages. */
std::string toBytes(const Sample& sample);
/** Inverts toBytes(). \exception std::runtime_error If the data is damaged. */
Sample sampleOf(std::string_view bytes);

/** Adds a sample to a message.
 * \param[in] most Largest size of the message, bytes.
 * \return False if it does not fit: the message is as before. */
bool addTo(std::string& message, const Sample& sample, size_t most = kMostMessageBytes);
/** Returns the samples of a message. \exception std::runtime_error If the message is damaged. */
std::vector<Sample> samplesOf(std::string_view message);

}  // namespace mrpt::fusion
