// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Guesses of poses in g2o files. */

#include "fuzz/fuzz_target.h"
#include "map-fusion/priors.h"

using namespace mrpt::fusion;
using namespace map_fusion;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr size_t kMaps = 4;
  fuzz::accepts([&] {
    const Priors priors = parsePriors(std::string(fuzz::asText(data, size)), kMaps);
    for (size_t b = 0; b < kMaps; b++)
      for (size_t a = 0; a < b; a++)
        if (const auto prior = priors.of(a, b))
          fuzz::require(prior->pdf().cov.asEigen().allFinite() &&
                            toEigen(prior->guess()).matrix().allFinite(),
                        "a guess is finite");
  });
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  const std::string identity = "0 0 0 0 0 0 1";
  const std::string information = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";
  return {
      "# a comment\nVERTEX_SE3:QUAT 0 " + identity + "\nFIX 0\nVERTEX_SE3:QUAT 1 1 2 3 0 0 1 0\n",
      "EDGE_SE3:QUAT 2 0 1e2 -.5 0 0.6 0 0.8 0 4 0 0 0 0 0 4 0 0 0 0 4 0 0 0 9 0 0 9 0 9\n",
      "EDGE_SE3:QUAT 0 3 " + identity + information + "\n"};
}
