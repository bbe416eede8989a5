// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Poses as the command line takes them: "[x y z yaw pitch roll]", or else the contents of a file
 * with a 4x4 matrix. */

#include <mrpt/fusion/poses.h>

#include "fuzz/fuzz_target.h"
#include "map-fusion/pose.h"

using namespace mrpt::fusion;
using namespace map_fusion;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static fuzz::MemoryFile file;
  const std::string text(fuzz::asText(data, size));
  const size_t first = text.find_first_not_of(" \t");
  const bool in_brackets = first != std::string::npos && text[first] == '[';
  fuzz::accepts([&] {
    const auto pose = parsePose(in_brackets ? text : file.with(text));
    fuzz::require(toEigen(pose).matrix().allFinite(), "a pose is finite");
    parsePose(file.with(toMatrixText(pose)));
  });
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  return {"[1 2 0.5 30 0 -5]", "  [ 1e3 -2.5 .5 -180 90 0 ]\t",
          "1 0 0 4\n0 1 0 5\n0 0 1 6\n0 0 0 1\n",
          "0 -1 0 1e2\n1 0 0 -0.5\n0 0 1.0000001 0x1p-3\n0 0 0 1\n"};
}
