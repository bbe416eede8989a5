// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Collects the matches that hold the placed maps of a team together. */
#include "fusion_team/graph/team_links.h"

#include <algorithm>

#include "fusion_core/pair/align_from.h"

namespace mrpt::fusion {
namespace {

/** Returns the hypothesis of a match that agrees with a pose of B, the nearest if none agrees. */
RankedPose hypothesisAt(const PairMatch& m, const Eigen::Isometry3d& T_a_b,
                        const TeamEvidence& evidence) {
  const MatchResult& match = m.alignment.match;
  std::vector<RankedPose> possible = match.hypotheses;
  if (possible.empty()) possible.emplace_back();
  possible.front() = {match.T_a_b, possible.front().agreement, match.covariance};
  const auto same = std::find_if(possible.begin(), possible.end(), [&](const RankedPose& h) {
    return evidence.isSame(m.b, evidence.near(m.a, m.b, h.T_a_b).T_a_b, T_a_b);
  });
  if (same != possible.end()) return *same;
  const auto distance = [&](const RankedPose& h) {
    return (h.T_a_b.translation() - T_a_b.translation()).norm();
  };
  return *std::min_element(
      possible.begin(), possible.end(),
      [&](const RankedPose& g, const RankedPose& h) { return distance(g) < distance(h); });
}

bool contains(const std::vector<size_t>& maps, size_t k) {
  return std::find(maps.begin(), maps.end(), k) != maps.end();
}

}  // namespace

void addLinks(const std::vector<RobotMap>& maps, const Options& options,
              const std::vector<PlacedMap>& placed, const std::vector<PairMatch>& matches,
              const TeamEvidence& evidence, Executor& executor, PairMemory& memory,
              std::vector<FusionMember>& members) {
  std::vector<std::pair<const PairMatch*, FusionLink>> loops;
  for (size_t k = 0; k < members.size(); k++) {
    const MatchResult& match = members[k].alignment.match;
    if (k > 0 && placed[k].placed)
      members[k].links.push_back({*placed[k].parent, match.T_a_b, match.covariance});
  }
  for (const PairMatch& m : matches) {
    const PlacedMap &a = placed[m.a], &b = placed[m.b];
    const bool is_link = a.placed && b.placed && contains(b.ways_in, m.a);
    if (is_link && b.parent != m.a && a.parent != m.b) loops.push_back({&m, {m.a}});
  }
  executor.run(loops.size(), [&](size_t i) {
    const PairMatch& m = *loops[i].first;
    FusionLink& link = loops[i].second;
    const Eigen::Isometry3d T = placed[m.a].pose->inverse() * *placed[m.b].pose;
    const RankedPose h = hypothesisAt(m, T, evidence);
    link.T_a_b = h.T_a_b;
    link.covariance = h.covariance;
    if (h.covariance.trace() < kUnknownVariance) return;
    const PreparedMap &map_a = maps[m.a].map, &map_b = maps[m.b].map;
    const Alignment registered = memory.registration(
        map_a, map_b, h.T_a_b, [&] { return alignFrom(map_a, map_b, h.T_a_b, options); });
    link.T_a_b = registered.match.T_a_b;
    link.covariance = registered.match.covariance;
  });
  for (const auto& [m, link] : loops) members[m->b].links.push_back(link);
}

}  // namespace mrpt::fusion
