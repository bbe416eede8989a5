// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CObservationMapDiff. After a first byte of 0 the input is a serialized diff; else it is the parts
 * of diffs of one robot, in plain form, because checksums hide them from the fuzzer. */

#include <mrpt/obs/CObservationLocalMap.h>

#include <cstring>
#include <map>
#include <memory>
#include <sstream>

#include "fusion_link/map_index.h"
#include "fusion_octree/files.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"
#include "mrpt_fusion_maps/missions.h"
#include "support/mrpt_tools.h"

using namespace mrpt::fusion;
using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationMapDiff;

namespace {

constexpr size_t kHashAt = sizeof(uint64_t);  // in a plain index, after the version

/** Reads and makes the plain parts of a diff. */
class PlainDiffs {
 public:
  explicit PlainDiffs(std::string_view bytes)
      : input_(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()) {}

  bool isEmpty() const { return input_.isEmpty(); }

  CObservationMapDiff::Ptr next() {
    auto diff = CObservationMapDiff::Create();
    diff->sensorLabel = "a";
    diff->version = input_.take<uint32_t>();
    const bool has_right_hash = input_.take<uint8_t>() % 2 == 0;
    std::string index(takeText());
    for (auto count = input_.take<uint8_t>(); count > 0 && !isEmpty(); count--) {
      const auto cube = input_.take<uint64_t>();
      const auto version = input_.take<uint32_t>();
      diff->blocks.push_back({cube, version, fuzz::xzCompressed(takeText())});
    }
    if (has_right_hash) setHash(*diff, index);
    diff->index = fuzz::xzCompressed(index);
    return diff;
  }

  static std::string of(const CObservationMapDiff& diff) {
    fuzz::Output output;
    output.put(static_cast<uint32_t>(diff.version)).put(uint8_t{0});
    std::string bytes = output.bytes() + text(fuzz::xzDecompressed(diff.index));
    bytes += static_cast<char>(diff.blocks.size());
    for (const auto& block : diff.blocks)
      bytes += fuzz::Output().put(block.cube).put(static_cast<uint32_t>(block.version)).bytes() +
               text(fuzz::xzDecompressed(block.nodes));
    return bytes;
  }

 private:
  std::string_view takeText() {
    const size_t size = input_.take<uint16_t>();
    const std::string_view text = input_.rest().substr(0, size);
    const std::string_view rest = input_.rest().substr(text.size());
    input_ = fuzz::Input(reinterpret_cast<const uint8_t*>(rest.data()), rest.size());
    return text;
  }
  static std::string text(const std::string& bytes) {
    return fuzz::Output().put(static_cast<uint16_t>(bytes.size())).bytes() + bytes;
  }

  /** Writes the hash of the blocks that the index names into the index, as far as it is one. */
  void setHash(const CObservationMapDiff& diff, std::string& index) {
    for (const auto& block : diff.blocks)
      blocks_[block.cube] = std::make_shared<const std::string>(block.nodes);
    fuzz::accepts([&] {
      std::map<BlockCode, BlockBytes> named;
      for (const auto& block : indexOf(fuzz::xzCompressed(index)).blocks)
        if (const auto found = blocks_.find(block.first); found != blocks_.end())
          named.insert(*found);
      const uint64_t hash = hashOf(named);
      std::memcpy(&index[kHashAt], &hash, sizeof(hash));
    });
  }

  fuzz::Input input_;
  std::map<BlockCode, BlockBytes> blocks_;
};

/** A diff as it comes from a file; null if it is refused. */
CObservationMapDiff::Ptr fromStream(std::string_view bytes) {
  auto diff = CObservationMapDiff::Create();
  if (!fuzz::accepts([&] { map_tests::deserializeInto(bytes, *diff); })) return nullptr;
  std::ostringstream text;
  diff->getDescriptionAsText(text);
  return diff;
}

/** What a mission and a map make of the diffs of one robot is the same. */
class Receivers {
 public:
  void add(const CObservationMapDiff::Ptr& diff) {
    const bool is_taken = fuzz::accepts([&] { mission_.add(diff); });
    bool is_inserted = false;
    const bool is_answered = fuzz::accepts([&] { is_inserted = map_.insertObservation(*diff); });
    fuzz::require(is_taken == is_answered, "both take a diff, or both refuse it");
    if (is_inserted) compare();
  }

 private:
  void compare() {
    const auto maps = mission_.maps();
    const auto& map = dynamic_cast<const CProbOctoMap&>(*maps.at(0)->map);
    fuzz::require(serializeNodes(map.octree()) == serializeNodes(map_.octree()),
                  "a mission and a map make the same map of diffs");
    const auto again = MapDiffs("a").next(map.octree());
    CProbOctoMap copy;
    fuzz::require(again && copy.insertObservation(*again), "the diff of a map is inserted");
    fuzz::require(serializeNodes(map.octree()) == serializeNodes(copy.octree()),
                  "a map is the same after it was sent");
  }

  LatestMaps mission_;
  CProbOctoMap map_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::Input input(data, size);
  Receivers receivers;
  if (input.take<uint8_t>() == 0) {
    if (const auto diff = fromStream(input.rest())) receivers.add(diff);
    return 0;
  }
  PlainDiffs diffs(input.rest());
  while (!diffs.isEmpty())
    if (const auto diff = fromStream(map_tests::serialized(*diffs.next()))) receivers.add(diff);
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  std::vector<std::string> seeds;
  std::string row(1, '\1');
  MapDiffs changes("a");
  for (const auto& tree : fuzz::smallTrees()) {
    if (const auto whole = MapDiffs("a").next(*tree)) {
      seeds.push_back('\0' + map_tests::serialized(*whole));
      seeds.push_back('\1' + PlainDiffs::of(*whole));
    }
    if (const auto change = changes.next(*tree)) row += PlainDiffs::of(*change);
  }
  seeds.push_back(row);
  return seeds;
}
