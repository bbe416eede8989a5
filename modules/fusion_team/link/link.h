// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "fusion_team/ledger/source.h"

/** \file
 * The interface to the other robots of a team. */

namespace mrpt::fusion {

/** What a sample holds, in the order in which samples are sent. */
enum class SampleKind : uint8_t {
  Have,     ///< What a robot has of the map of the receiver
  Want,     ///< Blocks of the map of the receiver that a robot wants first
  Index,    ///< Piece of the list of the blocks of a map
  Outline,  ///< Piece of the outline of a map
  Block,    ///< Block of a map
  Claim     ///< Claim to a name, to another robot of this name
};

/** Identity of a sample: only the latest version of each key counts. */
struct SampleKey {
  SourceName source;                   ///< Robot that sends the sample, and its map
  SampleKind kind = SampleKind::Have;  ///< What the sample holds
  uint64_t number = 0;                 ///< Number of the block or of the piece

  bool operator<(const SampleKey& o) const {
    return std::tie(source, kind, number) < std::tie(o.source, o.kind, o.number);
  }
  bool operator==(const SampleKey& o) const {
    return source == o.source && kind == o.kind && number == o.number;
  }
};

/** A value that robots send to each other. */
struct Sample {
  SampleKey key;         ///< Identity
  uint64_t version = 0;  ///< Version of the map at which the value changed last
  std::string bytes;     ///< Value, at most kMostSampleBytes
};

/** Largest size of the value of a sample, bytes. */
constexpr size_t kMostSampleBytes = 8000;
/** Largest number of characters of the name of a robot or of a map. */
constexpr size_t kMostNameCharacters = 63;

/** Largest size of a message, bytes: one sample of any size, or several. */
constexpr size_t kMostMessageBytes = 8192;

/** A link to the other robots. It brings messages to one robot at a time.
 *
 * A robot that is there has a session. What is sent to a robot arrives once and in order as long as
 * the session lasts. If the session ends, messages may be lost. A robot that comes back has another
 * session. The two robots may not agree on when a session ended.
 *
 * One thread uses a link at a time. */
class Link {
 public:
  virtual ~Link() = default;
  /** Returns the robots that are there, by their names, with the numbers of their sessions. The
   * names come from outside: they may be anything, also the name of this robot. */
  virtual std::map<std::string, uint64_t> sessions() = 0;
  /** Sends a message to a robot. \param[in] message At most kMostMessageBytes.
   * \return False if the link is busy or the robot has gone: nothing is sent, try again later. */
  virtual bool send(const std::string& robot, const std::string& message) = 0;
  /** Returns messages that have arrived, at most \a most. They come from outside: they may be
   * anything. */
  virtual std::vector<std::string> receive(size_t most) = 0;
  /** Waits until messages arrive, or for a time. */
  virtual void wait(std::chrono::milliseconds most) = 0;
};

}  // namespace mrpt::fusion
