// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>

/** \file
 * The memory that a file may ask for. */

namespace mrpt::fusion {

/** Limits of what a file may ask for. A plain file of OctoMap stays below them: a `.bt` file needs
 * at most 96 times its size in memory. */
struct FileBudget {
  size_t bytes;   ///< Largest number of unpacked bytes
  size_t memory;  ///< Largest memory of the nodes, bytes

  /** Returns the budget of a file. \param[in] file_bytes Size of the file, bytes. */
  static FileBudget of(size_t file_bytes) {
    constexpr size_t kLeastBytes = size_t{128} << 20U, kBytesPerByte = 64;
    constexpr size_t kLeastMemory = size_t{512} << 20U, kMemoryPerByte = 400;
    return {std::max(kLeastBytes, kBytesPerByte * file_bytes),
            std::max(kLeastMemory, kMemoryPerByte * file_bytes)};
  }
};

}  // namespace mrpt::fusion
