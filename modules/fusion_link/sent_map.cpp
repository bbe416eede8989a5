// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Finds what has changed in a robot's own map. */
#include "fusion_link/sent_map.h"

#include <cstring>
#include <stdexcept>
#include <utility>

#include "fusion_link/outline.h"

namespace mrpt::fusion {
namespace {

/** Number of low bits of a version that are the number of the run. The other bits count. */
constexpr unsigned kRunBits = 16;

bool isSame(const Trunk& a, const Trunk& b) {
  const auto bits = [](const Trunk& t) {
    std::string bytes(reinterpret_cast<const char*>(&t.model), sizeof(t.model));
    for (const auto& value : t.values)
      bytes.append(reinterpret_cast<const char*>(&value.second), sizeof(value.second));
    return bytes;
  };
  if (a.resolution != b.resolution || a.values.size() != b.values.size()) return false;
  for (size_t i = 0; i < a.values.size(); i++)
    if (a.values[i].first != b.values[i].first) return false;
  return bits(a) == bits(b);
}

}  // namespace

SentMap::SentMap(const MapReplica& sent, unsigned run)
    : source_(sent.source()), run_(run & ((1U << kRunBits) - 1)) {
  if (sent.completeVersion() == 0) {
    index_.version = sent.highestVersion();  // what is new must be newer than what was sent
    return;
  }
  index_ = *sent.index();
  blocks_ = *sent.blocks();
  map_ = joinBlocks(blocks_);
  if (sent.outline()) outlined_bytes_ = bytesOf(blocks_);
}

uint64_t SentMap::versionAfter(uint64_t version) const {
  const uint64_t next = ((version >> kRunBits) + 1) << kRunBits | run_;
  if (next > kMostVersion) throw std::runtime_error("the map has no further version");
  return next;
}

std::vector<Sample> SentMap::update(std::shared_ptr<const octomap::OcTree> map) {
  MapBlocks blocks = divideIntoBlocks(*map, map_.get(), blocks_);
  bool is_same = map_ && isSame(blocks.trunk, blocks_.trunk);
  const uint64_t version = versionAfter(index_.version);
  std::map<BlockCode, uint64_t> versions;
  for (const auto& [code, bytes] : blocks.blocks) {
    const auto before = blocks_.blocks.find(code);
    const bool is_known = before != blocks_.blocks.end() && *before->second == *bytes;
    versions[code] = is_known ? index_.blocks.at(code) : version;
    is_same = is_same && is_known;
  }
  if (is_same && blocks.blocks.size() == blocks_.blocks.size()) return {};
  for (const auto& block : blocks_.blocks)
    if (blocks.blocks.count(block.first) == 0)
      obsolete_.push_back({source_, SampleKind::Block, block.first});
  map_ = std::move(map);
  blocks_ = std::move(blocks);
  index_ = {version, blocks_.trunk, std::move(versions), hashOf(blocks_.blocks)};
  return samplesSince(version);
}

std::vector<Sample> SentMap::continueAbove(uint64_t version) {
  index_.version = versionAfter(version);
  if (!map_) return {};
  for (auto& block : index_.blocks) block.second = index_.version;
  outlined_bytes_ = 0;
  return samplesSince(index_.version);
}

std::vector<Sample> SentMap::samplesSince(uint64_t version) {
  auto samples = cutIntoPieces(source_, SampleKind::Index, index_.version, toBytes(index_));
  constexpr size_t kGrowth = 2;
  if (const size_t bytes = bytesOf(blocks_); bytes >= kGrowth * outlined_bytes_) {
    outlined_bytes_ = bytes;
    if (const std::string outline = outlineOf(*map_); !outline.empty())
      for (Sample& piece : cutIntoPieces(source_, SampleKind::Outline, index_.version, outline))
        samples.push_back(std::move(piece));
  }
  for (const auto& [code, changed] : index_.blocks)
    if (changed >= version)
      samples.push_back({{source_, SampleKind::Block, code}, changed, *blocks_.blocks.at(code)});
  return samples;
}

}  // namespace mrpt::fusion
