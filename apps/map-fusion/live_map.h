// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "run_context.h"

/** \file
 * A map file that another program writes again and again. */

namespace map_fusion {

/** Reads a map file when it changes. */
class LiveMap {
 public:
  explicit LiveMap(std::string path) : path_(std::move(path)) {}

  /** Returns the map if the file has changed since the last call, otherwise null. A file that
   * cannot be read, as while it is being written, or is gone, is noted once, and read again when it
   * changes.
   * \exception std::runtime_error "<path>: <reason>" if the first call cannot read the file. */
  std::shared_ptr<const octomap::OcTree> readIfChanged(RunContext& run);

 private:
  struct State {
    std::filesystem::file_time_type time;
    uintmax_t size;
    bool operator==(const State& o) const { return time == o.time && size == o.size; }
  };

  /** Notes once why the file cannot be read. \return Null. */
  std::shared_ptr<const octomap::OcTree> keepLast(RunContext& run, const std::string& reason);

  std::string path_;
  std::optional<State> read_;  // of the file that was read last
  bool is_noted_ = false;
};

}  // namespace map_fusion
