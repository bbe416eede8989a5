// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/map_fusion.h>

#include <algorithm>
#include <utility>

#include "fusion_base/error_text.h"

using namespace mrpt::fusion;
using mrpt::obs::CObservationLocalMap;

bool FusionResult::isComplete() const {
  return std::all_of(members.begin(), members.end(),
                     [](const auto& m) { return m.joined || m.info.by_edges; });
}

FusionResult mrpt::fusion::fuseMaps(const mrpt::slam::CProbabilisticMapMatching& matching,
                                    const std::vector<CObservationLocalMap::Ptr>& maps,
                                    bool even_rejected, const OnMember& on_member) {
  std::vector<MatchableMap> matchables;  // what the views point to
  std::vector<RobotMap> robots;
  for (const auto& m : maps) {
    ASSERTMSG_(m && m->map, "fuseMaps(): a robot's map is missing");
    mrpt::fusion::withPath(m->sensorLabel, [&] { matchables.push_back(matchable(*m->map)); });
    robots.push_back({m->sensorLabel, matchables.back().view, m->pose});
  }
  auto fused = mrpt::fusion::fuseMaps(robots, matching.options, even_rejected, on_member,
                                      matching.onIteration);
  return {mrpt::maps::CProbOctoMap(std::move(fused.map)), std::move(fused.members)};
}
