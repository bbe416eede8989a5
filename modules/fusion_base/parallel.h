// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

/** \file
 * Parallel loops with results that do not depend on the number of threads. */

namespace mrpt::fusion {

/** Number of voxels per task. */
constexpr size_t kGrain = 512;

/** Calls f(begin, end) for pieces of [0, n), in parallel. f must compute each index independently
 * and write only data of its piece. The result then does not depend on the number of threads.
 * \param[in] n Number of indices.
 * \param[in] grain Number of indices up to which a piece is not divided. The work of a piece
 * must be large against the cost of scheduling.
 * \param[in] f The function. */
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
