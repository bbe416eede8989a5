// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion fuse` for the maps of a team. */

#include <mrpt/fusion/many_maps.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.h"
#include "fusion_base/error_text.h"
#include "fusion_base/printable.h"
#include "inputs.h"
#include "joined_recordings.h"
#include "map_pair.h"
#include "pages.h"
#include "poses_out.h"
#include "priors.h"

using mrpt::fusion::FusionMember;

namespace map_fusion {

namespace {

/** Adds guesses to maps. If there are poses, they are the common frame of all maps. */
void applyPriors(const Priors& priors, std::vector<mrpt::fusion::RobotMap>& maps) {
  for (const auto& [pair, prior] : priors.pairs)
    maps[pair.second].guesses.push_back({maps[pair.first].robot, prior});
  if (priors.poses.empty()) return;
  for (size_t k = 0; k < maps.size(); k++) {
    const auto pose = priors.poses.find(k);
    maps[k].pose = pose == priors.poses.end() ? mrpt::fusion::noGuess()
                                              : mrpt::poses::CPose3DPDFGaussian(pose->second);
  }
}

/** Returns the names of the robots whose matches are rejected. */
std::string rejectedOf(const std::vector<FusionMember>& members) {
  std::string names;
  for (const FusionMember& m : members)
    if (m.hasMatch() && !m.alignment.by_edges && !m.alignment.evaluation.accepted)
      names += (names.empty() ? "" : ", ") + m.robot;
  return names;
}

}  // namespace

bool runFuseTeam(RunContext& run) {
  checkRecordings(run);
  const auto robots = loadRobots(run);
  if (robots.size() < 2)
    throw UsageError(run.args.maps[0] +
                     ": holds one map. Give two maps, or a rawlog of several robots' maps");
  choosePolicy(run);
  std::vector<mrpt::fusion::RobotMap> maps;
  maps.reserve(robots.size());
  std::optional<Priors> priors;
  if (!run.args.priors.empty()) priors = loadPriors(run.args.priors, robots.size());
  run.progress.show("extracting edges");
  for (const Robot& robot : robots)
    mrpt::fusion::withPath(robot.name, [&] {
      maps.push_back({robot.name, robot.map.prepared(run.options.features), robot.pose});
    });
  if (priors) applyPriors(*priors, maps);
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
  for (const FusionMember& m : members)
    if (m.joined && joined > 1) noteCounting(run, m.robot, m.counting, m.counted_with);
  const std::shared_ptr<const octomap::OcTree> fused = std::move(result.map);
  if (joined > 1) {
    saveFused(run, fused, result.sources);
  } else {
    run.report.policy.clear();
    std::cerr
        << (is_mergeable
                ? "map-fusion: all matches are rejected, nothing was merged (--force merges)\n"
                : "map-fusion: nothing was merged: only one robot sent more than edges\n");
  }
  savePoses(run, joined > 1);
  drawTeamPage(run, robots, joined > 1 ? fused : nullptr);
  const std::string rejected = rejectedOf(members);
  if (joined > 1 && !rejected.empty())
    std::cerr << "map-fusion: rejected: " << mrpt::fusion::printable(rejected) << "\n";
  return joined > 1 && rejected.empty();
}

}  // namespace map_fusion
