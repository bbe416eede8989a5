// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Octree files, .ot and .bt. */

#include <octomap/OcTree.h>

#include "fusion_octree/files.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"

using namespace mrpt::fusion;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::unique_ptr<octomap::OcTree> tree;
  if (!fuzz::accepts([&] { tree = parseOcTreeFile(fuzz::asText(data, size)); })) return 0;
  const std::string written = toOtFile(*tree);
  fuzz::require(toOtFile(*parseOcTreeFile(written)) == written,
                "a map is the same after it was written and read");
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  std::vector<std::string> seeds;
  for (const auto& tree : fuzz::smallTrees()) {
    seeds.push_back(toOtFile(*tree));
    seeds.push_back(toBtFile(*tree));
  }
  return seeds;
}
