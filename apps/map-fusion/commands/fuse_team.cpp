// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion fuse` for the maps of a team. */

#include <mrpt/fusion/many_maps.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.h"
#include "fusion_base/error_text.h"
#include "inputs.h"
#include "map_pair.h"
#include "pages.h"

using mrpt::fusion::FusionMember;

namespace map_fusion {

bool runFuseTeam(RunContext& run) {
  const auto robots = loadRobots(run);
  if (robots.size() < 2)
    throw std::runtime_error(run.args.maps[0] +
                             ": holds one map. Give two maps, or a rawlog of several robots' maps");
  choosePolicy(run);
  std::vector<mrpt::fusion::RobotMap> maps;
  maps.reserve(robots.size());
  run.progress.show("extracting edges");
  for (const Robot& robot : robots)
    mrpt::fusion::withPath(robot.name, [&] {
      maps.push_back({robot.name, robot.map.prepared(run.options.features), robot.pose});
    });
  const auto on_member = [&](const std::string& robot, size_t joined) {
    run.progress.show("matching " + robot + " with " + std::to_string(joined) + " joined maps");
  };
  auto result =
      mrpt::fusion::fuseMaps(maps, run.options, run.args.force, on_member, run.on_iteration);
  run.progress.clear();
  run.endStep("fuse");

  run.report.members = std::move(result.members);
  run.report.pairs = std::move(result.pairs);
  const auto& members = run.report.members;
  const auto joined =
      std::count_if(members.begin(), members.end(), [](const auto& m) { return m.joined; });
  const bool is_mergeable = std::any_of(members.begin(), members.end(), [](const FusionMember& m) {
    return m.hasMatch() && !m.alignment.by_edges;
  });
  const std::shared_ptr<const octomap::OcTree> fused = std::move(result.map);
  if (joined > 1)
    saveFused(run, fused);
  else if (is_mergeable)
    std::cerr << "map-fusion: all matches are rejected, nothing was merged (--force merges)\n";
  else
    std::cerr << "map-fusion: nothing was merged: only one robot sent more than edges\n";
  drawTeamPage(run, robots, joined > 1 ? fused : nullptr);
  const bool accepted = std::all_of(members.begin(), members.end(), [](const FusionMember& m) {
    return m.alignment.by_edges || !m.hasMatch() || m.alignment.evaluation.accepted;
  });
  return joined > 1 && accepted;
}

}  // namespace map_fusion
