// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fusion_team/link/link.h"

/** \file
 * Values that need more than one sample. */

namespace mrpt::fusion {

/** Largest number of pieces of a value: bounds the memory of a receiver. */
constexpr size_t kMostPieces = 128;

/** Cuts a value into samples. The number of the key is that of the piece.
 * \exception std::length_error If there are more than kMostPieces pieces. */
std::vector<Sample> cutIntoPieces(const SourceName& source, SampleKind kind, uint64_t version,
                                  std::string_view value);

/** The pieces of one value that have arrived. Versions may be mixed. */
class Pieces {
 public:
  /** Adds a piece. Of two pieces with the same number the newer counts.
   * \return False if nothing changed.
   * \exception std::runtime_error If the piece is damaged. */
  bool add(const Sample& piece);
  /** Returns the newest value all pieces of which have arrived, with its version. */
  std::optional<std::pair<uint64_t, std::string>> value() const;
  /** Returns all pieces by their number. */
  const std::map<uint64_t, Sample>& all() const { return pieces_; }

 private:
  std::map<uint64_t, Sample> pieces_;
};

/** True if \a a replaces \a b, which has the same key: versions decide, then bytes, so that the
 * order of arrival does not matter. */
bool isNewer(const Sample& a, const Sample& b);

}  // namespace mrpt::fusion
