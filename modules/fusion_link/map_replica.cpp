// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Collects the samples of a map. */
#include "fusion_link/map_replica.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <tuple>
#include <utility>

#include "fusion_base/byte_reader.h"

namespace mrpt::fusion {
namespace {

/** Bytes of a key and its entry, so that empty samples cost something, too. */
constexpr size_t kEntryBytes = 64;

size_t costOf(const std::string& bytes) { return kEntryBytes + bytes.size(); }

}  // namespace

bool MapReplica::add(const Sample& sample) {
  if (!take(sample)) return false;
  finish();
  return true;
}

void MapReplica::add(const std::vector<Sample>& samples) {
  for (const Sample& sample : samples) take(sample);
  finish();
}

/** Adds a sample of the map, without a look at the map as a whole. */
bool MapReplica::take(const Sample& sample) {
  if (sample.version == 0 || sample.version > kMostVersion)
    corrupt("a sample has a version that is out of range");
  if (sample.bytes.size() > kMostSampleBytes) corrupt("a sample is too large");
  if (bytes() + costOf(sample.bytes) > most_bytes_) corrupt("a map has too many bytes");
  bool is_new = false;
  switch (sample.key.kind) {
    case SampleKind::Block:
      is_new = addBlock(sample);
      break;
    case SampleKind::Index:
      is_new = addIndex(sample);
      break;
    case SampleKind::Outline:
      is_new = outline_pieces_.add(sample);
      break;
    default:
      corrupt("a sample is of another kind");
  }
  if (is_new) highest_version_ = std::max(highest_version_, sample.version);
  return is_new;
}

bool MapReplica::addBlock(const Sample& sample) {
  const BlockCode code = sample.key.number;
  const auto known = blocks_.find(code);
  if (known != blocks_.end()) {
    const Held& held = known->second;
    if (std::tie(sample.version, sample.bytes) <= std::tie(held.version, *held.bytes)) return false;
  } else if (blocks_.size() >= 2 * kMostBlocks) {
    corrupt("a map has too many blocks");
  }
  checkBlock(code, sample.bytes);
  if (known != blocks_.end()) block_bytes_ -= costOf(*known->second.bytes);
  block_bytes_ += costOf(sample.bytes);
  blocks_[code] = {sample.version, std::make_shared<const std::string>(sample.bytes)};
  update(code);
  return true;
}

bool MapReplica::addIndex(const Sample& sample) {
  Pieces pieces = index_pieces_;
  if (!pieces.add(sample)) return false;
  const auto value = pieces.value();
  if (value && (!index_ || value->first >= index_->version)) {
    MapIndex index = indexOf(value->second);
    if (index.version != value->first) corrupt("the index of a map has another version");
    index_ = std::move(index);
    complete_version_ = 0;
    missing_.clear();
    for (const auto& block : index_->blocks) update(block.first);
  }
  index_pieces_ = std::move(pieces);
  return true;
}

void MapReplica::update(BlockCode code) {
  if (!index_) return;
  const auto wanted = index_->blocks.find(code);
  if (wanted == index_->blocks.end()) return;
  if (versionOf(code) == wanted->second) {
    missing_.erase(code);
  } else {
    missing_.insert(code);
    complete_version_ = 0;
  }
}

void MapReplica::finish() {
  if (!index_ || complete_version_ == index_->version) return;
  if (!missing_.empty() || hashOf(blocks()->blocks) != index_->hash) return;
  complete_version_ = index_->version;
  // Blocks that the map no longer has. Newer blocks belong to an index that is on its way.
  for (auto block = blocks_.begin(); block != blocks_.end();) {
    const Held& held = block->second;
    const bool is_old = held.version <= index_->version && index_->blocks.count(block->first) == 0;
    if (is_old) block_bytes_ -= costOf(*held.bytes);
    block = is_old ? blocks_.erase(block) : std::next(block);
  }
}

size_t MapReplica::bytes() const {
  size_t bytes = block_bytes_;
  for (const Pieces* pieces : {&index_pieces_, &outline_pieces_})
    for (const auto& piece : pieces->all()) bytes += costOf(piece.second.bytes);
  return bytes;
}

uint64_t MapReplica::versionOf(BlockCode code) const {
  const auto held = blocks_.find(code);
  return held == blocks_.end() ? 0 : held->second.version;
}

std::optional<MapBlocks> MapReplica::blocks() const {
  if (!index_) return std::nullopt;
  MapBlocks result{index_->trunk, {}};
  for (const auto& block : index_->blocks)
    if (const auto held = blocks_.find(block.first); held != blocks_.end())
      result.blocks.emplace(block.first, held->second.bytes);
  return result;
}

std::optional<std::string> MapReplica::outline() const {
  auto value = outline_pieces_.value();
  if (!value) return std::nullopt;
  return std::move(value->second);
}

std::vector<Sample> MapReplica::samples() const {
  std::vector<Sample> samples;
  for (const Pieces* pieces : {&index_pieces_, &outline_pieces_})
    for (const auto& piece : pieces->all()) samples.push_back(piece.second);
  for (const auto& [code, held] : blocks_)
    samples.push_back({{source_, SampleKind::Block, code}, held.version, *held.bytes});
  return samples;
}

}  // namespace mrpt::fusion
