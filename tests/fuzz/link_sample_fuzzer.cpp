// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * What arrives over a link. After a first byte of 0 the input is a row of samples, each with its
 * size; else it is the content of an index, because a checksum hides that from the fuzzer. */

#include "fusion_link/map_replica.h"
#include "fusion_link/name_dispute.h"
#include "fusion_link/outline.h"
#include "fusion_link/sent_map.h"
#include "fusion_link/statements.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"

using namespace mrpt::fusion;

namespace {

constexpr size_t kMostBytes = 1'000'000;  // of a map

void take(const Sample& sample, MapReplica& replica) {
  fuzz::accepts([&] { holdingsOf(sample.bytes); });
  fuzz::accepts([&] { wantedBlocksOf(sample.bytes); });
  fuzz::accepts([&] { NameDispute(1).hear(nameClaimOf(sample.bytes), 0); });
  fuzz::accepts([&] { replica.add(sample); });
  fuzz::require(replica.bytes() <= kMostBytes, "a map has no more bytes than allowed");
}

void takeAll(std::string_view input) {
  fuzz::accepts([&] { samplesOf(input); });
  MapReplica replica({"r1", ""}, kMostBytes);
  while (input.size() > sizeof(uint16_t)) {
    fuzz::Input head(reinterpret_cast<const uint8_t*>(input.data()), input.size());
    const size_t size = head.take<uint16_t>();
    const std::string_view bytes = head.rest().substr(0, size);
    input = head.rest().substr(bytes.size());
    fuzz::accepts([&] {
      const Sample sample = sampleOf(bytes);
      fuzz::require(toBytes(sample) == bytes, "a sample is the same after it was read");
      take(sample, replica);
    });
  }
  if (const auto outline = replica.outline()) fuzz::accepts([&] { outlineFrom(*outline); });
  if (const auto blocks = replica.blocks()) fuzz::accepts([&] { joinBlocks(*blocks); });
  if (replica.completeVersion() > 0)
    fuzz::require(replica.missing().empty(), "no block of a complete map is missing");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::Input input(data, size);
  if (input.take<uint8_t>() == 0) {
    takeAll(input.rest());
    return 0;
  }
  const std::string bytes = fuzz::xzCompressed(input.rest());
  fuzz::accepts([&] {
    const MapIndex index = indexOf(bytes);
    const MapIndex again = indexOf(toBytes(index));
    fuzz::require(again.version == index.version && again.blocks == index.blocks,
                  "an index is the same after it was packed");
  });
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  std::vector<std::string> seeds;
  for (const auto& tree : fuzz::smallTrees()) {
    const auto samples =
        SentMap(MapReplica({"r1", ""})).update(std::make_shared<const octomap::OcTree>(*tree));
    std::string row(1, '\0');
    for (const Sample& sample : samples) {
      const std::string bytes = toBytes(sample);
      row += fuzz::Output().put(static_cast<uint16_t>(bytes.size())).bytes() + bytes;
      if (sample.key.kind == SampleKind::Index)
        seeds.push_back('\1' + fuzz::xzDecompressed(sample.bytes.substr(sizeof(uint16_t))));
    }
    seeds.push_back(row);
  }
  const Holdings held{1, 2, 3, true, {4, 5}};
  const WantedBlocks wanted{{"r2", ""}, {1, 8, 9}};
  const NameClaim claim{2, 3, 1, 4};
  for (const std::string& value : {toBytes(held), toBytes(wanted), toBytes(claim)}) {
    const std::string bytes = toBytes(Sample{{{"r2", ""}, SampleKind::Have, 0}, 1, value});
    seeds.push_back('\0' + fuzz::Output().put(static_cast<uint16_t>(bytes.size())).bytes() + bytes);
  }
  return seeds;
}
