// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/resource.h>

#include <chrono>

namespace mrpt::fusion::benchmark {

/** Time since its construction. */
class Stopwatch {
 public:
  /** Of all threads of the process, user and system, s. */
  double cpu() const { return cpuNow() - cpu_; }
  double wall() const {  ///< s
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count();
  }

 private:
  static double cpuNow() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }

  double cpu_ = cpuNow();
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
};

/** Largest resident memory of the process so far, MB. */
inline double peakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace mrpt::fusion::benchmark
