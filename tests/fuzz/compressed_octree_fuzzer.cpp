// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Compressed octrees. After a first byte of 0 the input is the compressed data; else it is what
 * that data holds, because a checksum hides the inside from the fuzzer. */

#include "fusion_octree/compression.h"
#include "fusion_octree/files.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"

using namespace mrpt::fusion;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::Input input(data, size);
  const bool raw = input.take<uint8_t>() == 0;
  const std::string bytes = raw ? std::string(input.rest()) : fuzz::xzCompressed(input.rest());
  octomap::OcTree tree(0.1);
  if (!fuzz::accepts([&] { decompressNodes(bytes, tree); })) return 0;
  for (const Packing packing : {Packing::Fast, Packing::Smallest}) {
    octomap::OcTree again(0.1);
    decompressNodes(compressNodes(tree, packing), again);
    fuzz::require(serializeNodes(tree) == serializeNodes(again),
                  "a map is the same after it was compressed and decompressed");
  }
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  std::vector<std::string> seeds;
  for (const auto& tree : fuzz::smallTrees()) {
    const std::string compressed = compressNodes(*tree, Packing::Smallest);
    seeds.push_back('\0' + compressed);
    seeds.push_back('\0' + compressNodes(*tree, Packing::Fast));
    seeds.push_back('\1' + fuzz::xzDecompressed(compressed));
  }
  return seeds;
}
