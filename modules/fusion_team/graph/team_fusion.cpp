// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Places the maps of a team: pairs, configuration, verdict, poses. */
#include "fusion_team/graph/team_fusion.h"

#include <mrpt/core/exceptions.h>

#include <algorithm>
#include <string>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_core/pair/align_from.h"
#include "fusion_team/graph/joint_verdict.h"
#include "fusion_team/pairs/pair_matches.h"

namespace mrpt::fusion {
namespace {

/** Hypotheses of each match that may be part of a configuration. */
constexpr size_t kMostHypotheses = 12;
/** Configurations that the search grows, for each map. */
constexpr size_t kStartsPerMap = 4;

std::vector<JudgedWay> judged(const std::vector<Way>& ways, const std::vector<PairMatch>& matches,
                              const TeamEvidence& evidence) {
  std::vector<JudgedWay> result;
  for (const Way& way : ways) {
    const auto match = std::find_if(matches.begin(), matches.end(), [&](const PairMatch& m) {
      return m.a == way.a && m.b == way.b;
    });
    const Alignment& pair = match->alignment;
    const bool is_match = evidence.isSame(way.b, way.T_a_b, pair.match.T_a_b);
    result.push_back({way, is_match && pair.evaluation.accepted ? pair.evaluation.probability : 0});
  }
  return result;
}

/** Returns the best match of a map that is not placed with a placed map. */
FusionMember bestMatch(size_t k, const std::vector<PairMatch>& matches,
                       const std::vector<PlacedMap>& placed, const std::vector<RobotMap>& maps,
                       const Options& options) {
  const PairMatch* best = nullptr;
  for (const PairMatch& m : matches) {
    if ((m.a != k && m.b != k) || !placed[m.a == k ? m.b : m.a].placed) continue;
    if (!best || m.alignment.evaluation.probability > best->alignment.evaluation.probability)
      best = &m;
  }
  FusionMember member;
  const size_t other = best->a == k ? best->b : best->a;
  member.matched_with = maps[other].robot;
  member.alignment = best->b == k ? best->alignment
                                  : alignFrom(maps[other].map, maps[k].map,
                                              best->alignment.match.T_a_b.inverse(), options);
  member.alignment.evaluation.accepted = false;
  return member;
}

}  // namespace

std::vector<FusionMember> placeTeam(const std::vector<RobotMap>& maps, const Options& options,
                                    const OnMember& on_member) {
  for (const RobotMap& map : maps)
    withPath(map.robot,
             [&] { ASSERTMSG_(map.map.occupiedVoxels() > 0, "the map has no occupied voxel"); });

  // 1. Pairs: each map with each other map.
  ThreadExecutor executor;
  const std::vector<PairMatch> matches = matchPairs(maps, options, executor, on_member);

  // 2. Graph: the poses at which all pairs agree best, and their rivals.
  const EvidenceOfMaps evidence(maps, options);
  const std::vector<Way> ways = waysOf(matches, evidence, kMostHypotheses);
  const TeamSearchResult found = searchTeam(ways, evidence, kStartsPerMap * maps.size());

  // 3. Verdict: the maps whose place can be trusted.
  std::vector<std::string> names;
  for (const RobotMap& map : maps) names.push_back(map.robot);
  JointVerdictParams params;
  params.max_runner_up = options.evaluation.max_runner_up;
  params.max_conflict = options.evaluation.max_free_conflict;
  params.max_risk = 1 - options.evaluation.min_probability;
  const std::vector<PlacedMap> placed =
      judgeTeam(found, judged(ways, matches, evidence), evidence, names, params);

  // 4. Poses: each placed map is registered with its parent, with all voxels.
  std::vector<FusionMember> members(maps.size());
  executor.run(maps.size(), [&](size_t k) {
    const PlacedMap& p = placed[k];
    if (k == 0) return;
    if (p.placed) {
      const size_t parent = *p.parent;
      members[k].joined = true;
      members[k].matched_with = maps[parent].robot;
      members[k].alignment = alignFrom(maps[parent].map, maps[k].map,
                                       placed[parent].pose->inverse() * *p.pose, options);
      members[k].alignment.evaluation.accepted = true;
    } else {
      members[k] = bestMatch(k, matches, placed, maps, options);
    }
    members[k].alignment.evaluation.reasons = p.reasons;
    members[k].alignment.evaluation.runner_up = p.runner_up;
    members[k].alignment.evaluation.is_ambiguous = !p.placed && p.runner_up > params.max_runner_up;
  });
  members[0].joined = true;
  std::vector<size_t> order{0};
  for (size_t next = 0; next < order.size(); next++)
    for (size_t k = 1; k < maps.size(); k++)
      if (placed[k].placed && placed[k].parent == order[next]) {
        members[k].pose = order[next] == 0
                              ? members[k].alignment.pose()
                              : members[order[next]].pose + members[k].alignment.pose();
        order.push_back(k);
      }
  for (size_t k = 1; k < maps.size(); k++)
    if (!members[k].joined)
      for (size_t j = 0; j < maps.size(); j++)
        if (maps[j].robot == members[k].matched_with)
          members[k].pose =
              j == 0 ? members[k].alignment.pose() : members[j].pose + members[k].alignment.pose();
  for (size_t k = 0; k < maps.size(); k++) members[k].robot = maps[k].robot;
  return members;
}

}  // namespace mrpt::fusion
