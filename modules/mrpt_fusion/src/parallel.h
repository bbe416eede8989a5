// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace mrpt::fusion {

/** Calls f(i) for i in [0, n), in parallel; f writes only what belongs to i, so the result is the
 * same for any number of threads. */
template <class F>
void forEachIndex(size_t n, F&& f) {
  constexpr size_t kGrain = 512;  // indices per task: enough work to pay for scheduling
  tbb::parallel_for(tbb::blocked_range<size_t>(0, n, kGrain), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); i++) f(i);
  });
}

}  // namespace mrpt::fusion
