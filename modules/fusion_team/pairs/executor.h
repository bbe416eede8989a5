// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>

/** \file
 * Where the jobs of a team run. */

namespace mrpt::fusion {

/** Runs jobs that do not depend on each other. */
class Executor {
 public:
  virtual ~Executor() = default;
  /** Calls job(i) for i in [0, n), in any order and by any number of threads. Returns after the
   * last job. If jobs throw, one of their exceptions is thrown. */
  virtual void run(size_t n, const std::function<void(size_t)>& job) = 0;
};

/** Runs jobs in the threads of this process. */
class ThreadExecutor : public Executor {
 public:
  void run(size_t n, const std::function<void(size_t)>& job) override;
};

}  // namespace mrpt::fusion
