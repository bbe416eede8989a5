// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

/** \file
 * Silence of libraries. OctoMap prints to standard error when it reads or writes a binary octree
 * for MRPT. */

namespace map_fusion {

/** Silences standard error as long as it lives. Progress has a copy of it and is not affected. */
class SilentErrors {
 public:
  SilentErrors() : errors_(::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1)) {
    std::fflush(stderr);
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (errors_ >= 0 && nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
    if (nowhere >= 0) ::close(nowhere);
  }
  ~SilentErrors() {
    if (errors_ < 0) return;
    std::fflush(stderr);
    ::dup2(errors_, STDERR_FILENO);
    ::close(errors_);
  }
  SilentErrors(const SilentErrors&) = delete;
  SilentErrors& operator=(const SilentErrors&) = delete;

 private:
  int errors_;  // copy of standard error; negative if it is closed
};

}  // namespace map_fusion
