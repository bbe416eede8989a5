// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "fusion_team/ledger/source.h"

/** \file
 * The interface to the other robots of a team. */

namespace mrpt::fusion {

/** What a sample holds, in the order in which samples are sent. */
enum class SampleKind : uint8_t {
  Have,     ///< Versions of the maps that a robot has
  Want,     ///< Blocks that a robot wants first
  Index,    ///< Piece of the list of the blocks of a map
  Outline,  ///< Piece of the outline of a map
  Block     ///< Block of a map
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

/** Largest size of the value of a sample, bytes. Larger messages are lost as a whole if one of
 * their packets is lost, on some transports. */
constexpr size_t kMostSampleBytes = 8000;
/** Largest number of characters of the name of a robot or of a map. */
constexpr size_t kMostNameCharacters = 63;

/** A link to the other robots. It may lose, repeat and reorder samples for a while, but brings the
 * latest sample of each key to each robot that stays connected for long enough. A robot that comes
 * later gets the latest sample of each key, too.
 *
 * One thread uses a link at a time. */
class Link {
 public:
  virtual ~Link() = default;
  /** Sends a sample to all robots. It replaces the sample with the same key.
   * \return False if the link is busy: nothing is sent, try again later. */
  virtual bool send(const Sample& sample) = 0;
  /** Ends the sending of a sample that is obsolete. Robots that have it are not told. */
  virtual void forget(const SampleKey& key) = 0;
  /** Returns samples that have arrived, at most \a most. The samples come from outside: their
   * names, sizes and values may be anything. */
  virtual std::vector<Sample> receive(size_t most) = 0;
  /** Waits until samples arrive, or for a time. */
  virtual void wait(std::chrono::milliseconds most) = 0;
};

}  // namespace mrpt::fusion
