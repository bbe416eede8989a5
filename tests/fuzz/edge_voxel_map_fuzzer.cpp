// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Serialized CEdgeVoxelMap. After a first byte of 0 the input is the object; else it is the
 * compressed part of an object, in plain form. */

#include <mrpt/maps/CEdgeVoxelMap.h>

#include "fusion_octree/compression.h"
#include "fuzz/fuzz_blobs.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"

using namespace mrpt::fusion;
using mrpt::maps::CEdgeVoxelMap;

namespace {

/** A few edge voxels along two walls. */
const CEdgeVoxelMap& example() {
  static const CEdgeVoxelMap map = [] {
    EdgeVoxels edges;
    edges.resolution = 0.1;
    edges.direction_radius = 0.5;
    for (int i = 0; i < 12; i++) {
      edges.centre.emplace_back(0.05F + 0.1F * static_cast<float>(i), 0.05F, i % 2 ? 0.05F : 1.25F);
      edges.probability.push_back(0.7F + 0.02F * static_cast<float>(i));
    }
    return CEdgeVoxelMap(edges);
  }();
  return map;
}

const fuzz::Blob& blob() {
  static const fuzz::Blob blob(example());
  return blob;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::Input input(data, size);
  const bool raw = input.take<uint8_t>() == 0;
  const std::string bytes = raw ? std::string(input.rest()) : blob().replacedBy(input.rest());
  CEdgeVoxelMap map;
  if (!fuzz::accepts([&] { map_tests::deserializeInto(bytes, map); })) return 0;
  const std::string written = map_tests::serialized(map);
  CEdgeVoxelMap again;
  map_tests::deserializeInto(written, again);
  fuzz::require(map_tests::serialized(again) == written,
                "a map is the same after it was written and read");
  map.asString();
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  return {'\0' + map_tests::serialized(CEdgeVoxelMap()), '\0' + map_tests::serialized(example()),
          '\1' + blob().plain()};
}
