// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Fuses the maps that several robots have sent. */

#include <mrpt/fusion/fusion.h>
#include <mrpt/fusion/map_fusion.h>

#include <algorithm>
#include <utility>

#include "fusion_base/error_text.h"

using namespace mrpt::fusion;
using mrpt::obs::CObservationLocalMap;

bool FusionResult::isComplete() const {
  return std::all_of(members.begin(), members.end(),
                     [](const auto& m) { return m.joined || m.alignment.by_edges; });
}

FusionResult mrpt::fusion::fuseMaps(const mrpt::slam::CProbabilisticMapMatching& matching,
                                    const std::vector<CObservationLocalMap::Ptr>& maps,
                                    bool even_rejected, const OnMember& on_member) {
  std::vector<RobotMap> robots;
  robots.reserve(maps.size());
  for (const auto& m : maps) {
    ASSERTMSG_(m && m->map, "fuseMaps(): a robot's map is missing");
    withPath(m->sensorLabel, [&] {
      const mrpt::maps::CMetricMap::ConstPtr map = m->map;
      PreparedMap prepared = prepare(map, matching.options.features);
      if (prepared.sources().empty())
        prepared = prepared.withSources({{m->sensorLabel, {}, m->sequence, 0}});
      robots.push_back({m->sensorLabel, std::move(prepared), m->pose});
    });
  }
  auto fused = mrpt::fusion::fuseMaps(robots, matching.options, even_rejected, on_member,
                                      matching.onIteration);
  FusionResult result{mrpt::maps::CProbOctoMap(std::move(fused.map)), std::move(fused.members)};
  result.map.setSources(std::move(fused.sources));
  return result;
}
