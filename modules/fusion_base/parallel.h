// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace mrpt::fusion {

/** Voxels per task. */
constexpr size_t kGrain = 512;

/** Calls f(begin, end) for pieces of [0, n), in parallel; f writes only what belongs to its piece,
 * and each index by itself, so the result is the same for any number of threads. \param[in] grain
 * Least indices per piece: enough work to pay for scheduling it. */
template <class F>
void forEachRange(size_t n, size_t grain, F&& f) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, n, grain),
                    [&](const auto& range) { f(range.begin(), range.end()); });
}

/** Calls f(i) for i in [0, n), as forEachRange(). */
template <class F>
void forEachIndex(size_t n, size_t grain, F&& f) {
  forEachRange(n, grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i != end; i++) f(i);
  });
}

}  // namespace mrpt::fusion
