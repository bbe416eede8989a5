// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * A team of maps that changes. */
#include <mrpt/fusion/many_maps.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "fusion_team/graph/fuse_with_memory.h"

namespace mrpt::fusion {

struct MapTeam::Shared {
  explicit Shared(Options o) : options(std::move(o)) {}

  const Options options;
  std::mutex maps_mutex;       // of the maps and of the number of their changes
  std::vector<RobotMap> maps;  // in the order in which the robots came
  uint64_t changes = 0;

  std::mutex fusion_mutex;  // of all below
  TeamMemory memory;
  uint64_t fused_changes = 0;  // changes that the state knows
  std::shared_ptr<const TeamState> state = std::make_shared<const TeamState>();

  auto find(const std::string& robot) {
    return std::find_if(maps.begin(), maps.end(),
                        [&](const RobotMap& m) { return m.robot == robot; });
  }
};

MapTeam::MapTeam(Options options) : shared_(std::make_unique<Shared>(std::move(options))) {}
MapTeam::~MapTeam() = default;

void MapTeam::set(RobotMap map) {
  const std::lock_guard<std::mutex> lock(shared_->maps_mutex);
  const auto known = shared_->find(map.robot);
  if (known != shared_->maps.end())
    *known = std::move(map);
  else
    shared_->maps.push_back(std::move(map));
  shared_->changes++;
}

bool MapTeam::remove(const std::string& robot) {
  const std::lock_guard<std::mutex> lock(shared_->maps_mutex);
  const auto known = shared_->find(robot);
  if (known == shared_->maps.end()) return false;
  shared_->maps.erase(known);
  shared_->changes++;
  return true;
}

std::vector<std::string> MapTeam::robots() const {
  const std::lock_guard<std::mutex> lock(shared_->maps_mutex);
  std::vector<std::string> names;
  for (const RobotMap& m : shared_->maps) names.push_back(m.robot);
  return names;
}

std::shared_ptr<const TeamState> MapTeam::state() {
  const std::lock_guard<std::mutex> fusion_lock(shared_->fusion_mutex);
  std::vector<RobotMap> maps;
  uint64_t changes = 0;
  {
    const std::lock_guard<std::mutex> lock(shared_->maps_mutex);
    changes = shared_->changes;
    if (changes == shared_->fused_changes) return shared_->state;
    maps = shared_->maps;
  }
  shared_->state = std::make_shared<const TeamState>(
      maps.empty() ? TeamState() : fuseWithMemory(maps, shared_->options, shared_->memory));
  shared_->fused_changes = changes;
  shared_->memory.pairs.forgetUnused();
  return shared_->state;
}

}  // namespace mrpt::fusion
