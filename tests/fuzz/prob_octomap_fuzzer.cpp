// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Serialized CProbOctoMap. */

#include <mrpt/maps/CProbOctoMap.h>

#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"
#include "support/mrpt_tools.h"

using namespace mrpt::fusion;
using mrpt::maps::CProbOctoMap;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  CProbOctoMap map;
  if (!fuzz::accepts([&] { map_tests::deserializeInto(fuzz::asText(data, size), map); })) return 0;
  const std::string written = map_tests::serialized(map);
  CProbOctoMap again;
  map_tests::deserializeInto(written, again);
  fuzz::require(map_tests::serialized(again) == written,
                "a map is the same after it was written and read");
  map.asString();
  map.isEmpty();
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  std::vector<std::string> seeds;
  for (const auto& tree : fuzz::smallTrees())
    seeds.push_back(map_tests::serialized(CProbOctoMap(*tree)));
  CProbOctoMap fused(*fuzz::smallTrees().front());
  fused.setSources({{"r1", {}, 3, 0}, {{}, "b", 0, 42}});
  seeds.push_back(map_tests::serialized(fused));
  return seeds;
}
