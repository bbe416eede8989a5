// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "fusion_team/link/link.h"

/** \file
 * The samples of a robot on disk, so that it continues where it was after a crash. */

namespace mrpt::fusion {

/** A file of samples. Each sample is appended with a checksum. At a crash at most the samples after
 * the last sync() are lost. */
class Journal {
 public:
  /** Opens the journal of a folder, or makes both. Only one process may use it at a time.
   * \param[in] folder The folder.
   * \param[in] on_sample Called for each sample that the journal holds, in the order in which they
   * were appended. It may throw std::runtime_error for samples that it does not accept.
   * \exception std::runtime_error "<path>: <reason>" if the folder cannot be used. */
  Journal(const std::string& folder, const std::function<void(const Sample&)>& on_sample);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /** Appends a sample. \exception std::runtime_error "<path>: <reason>" as of a full disk. */
  void append(const Sample& sample);
  /** Returns when all samples are on the disk. \exception std::runtime_error See append(). */
  void sync();
  /** True if the file is much larger than samples of \a bytes bytes need. */
  bool isLarge(size_t bytes) const;
  /** Replaces the file by a file with these samples. \exception std::runtime_error See append(). */
  void rewrite(const std::vector<Sample>& samples);

 private:
  void open();
  [[noreturn]] void fail(const char* what) const;

  std::string path_;
  int file_ = -1;
  int lock_ = -1;
  size_t size_ = 0;        // bytes of the file
  bool is_dirty_ = false;  // true if samples are not on the disk yet
};

}  // namespace mrpt::fusion
