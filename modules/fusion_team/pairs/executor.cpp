// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Runs jobs in the threads of this process. */
#include "fusion_team/pairs/executor.h"

#include "fusion_base/parallel.h"

namespace mrpt::fusion {

void ThreadExecutor::run(size_t n, const std::function<void(size_t)>& job) {
  forEachIndex(n, 1, job);
}

}  // namespace mrpt::fusion
