// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace mrpt::fusion {

/** Voxels per task. */
constexpr size_t kGrain = 512;

/** Calls f(i) for i in [0, n), in parallel; f writes only what belongs to i, so the result is the
 * same for any number of threads. \param[in] grain Least indices per task: enough work to pay for
 * scheduling it. */
template <class F>
void forEachIndex(size_t n, size_t grain, F&& f) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, n, grain), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); i++) f(i);
  });
}

}  // namespace mrpt::fusion
