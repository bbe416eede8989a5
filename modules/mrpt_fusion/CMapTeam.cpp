// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The team of maps for MRPT: it prepares maps and calls mrpt::fusion::MapTeam. */

#include <mrpt/fusion/fusion.h>
#include <mrpt/slam/CMapTeam.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "fusion_base/error_text.h"

using namespace mrpt::slam;
using namespace mrpt::fusion;
using mrpt::maps::CProbOctoMap;

CMapTeam::CMapTeam(const Options& options) : features_(options.features), team_(options) {}

void CMapTeam::set(const std::string& robot, PreparedMap map,
                   const mrpt::poses::CPose3DPDFGaussian& pose) {
  ASSERTMSG_(map.occupiedVoxels() > 0, robot + ": the map has no occupied voxel");
  team_.set({robot, std::move(map), pose});
}

void CMapTeam::setMap(const std::string& robot, const mrpt::maps::CMetricMap& map,
                      const mrpt::poses::CPose3DPDFGaussian& pose) {
  set(robot, withPath(robot, [&] { return prepare(map, features_); }), pose);
}

bool CMapTeam::setMap(const mrpt::obs::CObservationLocalMap& sent) {
  const std::string& robot = sent.sensorLabel;
  ASSERTMSG_(sent.map, robot + ": the map is missing");
  const std::shared_ptr<const mrpt::maps::CMetricMap> map = sent.map;
  PreparedMap prepared = withPath(robot, [&] { return prepare(map, features_); });
  if (prepared.sources().empty()) prepared = prepared.withSources({{robot, {}, sent.sequence, 0}});
  const std::lock_guard<std::mutex> lock(sequences_mutex_);
  const auto known = sequences_.find(robot);
  if (known != sequences_.end() && sent.sequence < known->second) return false;
  set(robot, std::move(prepared), sent.pose);
  sequences_[robot] = sent.sequence;
  return true;
}

bool CMapTeam::removeMap(const std::string& robot) {
  const std::lock_guard<std::mutex> lock(sequences_mutex_);
  if (!team_.remove(robot)) return false;
  const auto sent = sequences_.find(robot);
  if (sent != sequences_.end() && sent->second < std::numeric_limits<uint64_t>::max())
    sent->second++;
  return true;
}

std::optional<FusionMember> CMapTeam::member(const std::string& robot) {
  const auto state = team_.state();
  const auto found = std::find_if(state->members.begin(), state->members.end(),
                                  [&](const FusionMember& m) { return m.robot == robot; });
  return found == state->members.end() ? std::nullopt : std::optional(*found);
}

std::shared_ptr<const CProbOctoMap> CMapTeam::fusedMap() {
  const auto state = team_.state();
  if (!state->map) return nullptr;
  const std::lock_guard<std::mutex> lock(fused_mutex_);
  if (fused_from_ != state) {
    auto map = std::make_shared<CProbOctoMap>(*state->map);
    map->setSources(state->sources);
    fused_ = std::move(map);
    fused_from_ = state;
  }
  return fused_;
}
