// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Cuts values into samples, and joins them. */
#include "fusion_link/pieces.h"

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "fusion_base/byte_reader.h"
#include "fusion_base/byte_writer.h"

namespace mrpt::fusion {
namespace {

/** A piece starts with the number of pieces of its value. */
using PieceCount = uint16_t;

PieceCount countOf(const Sample& piece) { return ByteReader(piece.bytes).take<PieceCount>(); }

}  // namespace

bool isNewer(const Sample& a, const Sample& b) {
  return std::tie(a.version, a.bytes) > std::tie(b.version, b.bytes);
}

std::vector<Sample> cutIntoPieces(const SourceName& source, SampleKind kind, uint64_t version,
                                  std::string_view value) {
  constexpr size_t kSize = kMostSampleBytes - sizeof(PieceCount);
  const size_t count = std::max<size_t>(1, (value.size() + kSize - 1) / kSize);
  if (count > kMostPieces) throw std::length_error("the map is too large to send");
  std::vector<Sample> pieces;
  for (size_t i = 0; i < count; i++) {
    Sample piece{{source, kind, i}, version, {}};
    appendValue(static_cast<PieceCount>(count), piece.bytes);
    piece.bytes += value.substr(i * kSize, kSize);
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

bool Pieces::add(const Sample& piece) {
  const PieceCount count = countOf(piece);
  if (count > kMostPieces || piece.key.number >= count) corrupt("a piece of a map is corrupt");
  const auto [known, is_new] = pieces_.emplace(piece.key.number, piece);
  if (is_new) return true;
  if (!isNewer(piece, known->second)) return false;
  known->second = piece;
  return true;
}

std::optional<std::pair<uint64_t, std::string>> Pieces::value() const {
  const auto first = pieces_.find(0);
  if (first == pieces_.end()) return std::nullopt;
  const PieceCount count = countOf(first->second);
  std::string value;
  for (uint64_t i = 0; i < count; i++) {
    const auto piece = pieces_.find(i);
    if (piece == pieces_.end() || piece->second.version != first->second.version ||
        countOf(piece->second) != count)
      return std::nullopt;
    value += piece->second.bytes.substr(sizeof(PieceCount));
  }
  return std::make_pair(first->second.version, std::move(value));
}

}  // namespace mrpt::fusion
