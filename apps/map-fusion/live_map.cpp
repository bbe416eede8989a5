// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads a map file when it changes. */

#include "live_map.h"

#include <stdexcept>
#include <system_error>

#include "fusion_base/error_text.h"
#include "inputs.h"

namespace map_fusion {

std::shared_ptr<const octomap::OcTree> LiveMap::readIfChanged(RunContext& run) {
  std::error_code error;
  const State now{std::filesystem::last_write_time(path_, error),
                  std::filesystem::file_size(path_, error)};
  const bool is_first = !read_;
  if (!is_first && error) return keepLast(run, path_ + ": is gone");
  if (!is_first && now == *read_) return nullptr;
  read_ = now;
  try {
    const auto octree = loadMap(run, run.args.robot, path_).octree;
    run.report.maps.pop_back();  // the fused map and its parts are reported
    is_noted_ = false;
    return octree;
  } catch (const std::runtime_error& e) {
    if (is_first) throw;
    return keepLast(run, mrpt::fusion::messageOf(e));
  }
}

std::shared_ptr<const octomap::OcTree> LiveMap::keepLast(RunContext& run,
                                                         const std::string& reason) {
  if (!is_noted_) run.note(reason + " (the last map that was read stays)");
  is_noted_ = true;
  return nullptr;
}

}  // namespace map_fusion
