// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The entry point of a libFuzzer program for one target. */

#include <tbb/global_control.h>

#include <cstddef>
#include <cstdint>

/** The target: the build gives its function this name. */
extern "C" int MRPT_FUSION_FUZZ_TARGET(const uint8_t* data, size_t size);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  // Small inputs gain nothing from threads, and several fuzzers run at a time.
  static const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 1);
  return MRPT_FUSION_FUZZ_TARGET(data, size);
}
