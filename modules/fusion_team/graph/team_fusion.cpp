// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Places the maps of a team: pairs, configuration, verdict, poses. */
#include "fusion_team/graph/team_fusion.h"

#include <mrpt/core/exceptions.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_core/pair/align_from.h"
#include "fusion_team/graph/pose_graph.h"
#include "fusion_team/graph/team_groups.h"
#include "fusion_team/graph/team_links.h"
#include "fusion_team/pairs/pair_matches.h"

namespace mrpt::fusion {
namespace {

/** Returns the hypotheses of all matches that the maps do not contradict. */
std::vector<Way> waysOf(const std::vector<PairMatch>& matches, const TeamEvidence& evidence) {
  std::vector<Way> ways;
  for (const PairMatch& m : matches)
    for (const Eigen::Isometry3d& T : hypothesesOf(m)) {
      const Way way{m.a, m.b, evidence.near(m.a, m.b, T).T_a_b};
      if (pairOf(way, evidence).score > 0) ways.push_back(way);
    }
  return ways;
}

std::vector<JudgedWay> judged(const std::vector<Way>& ways, const std::vector<PairMatch>& matches,
                              const EvidenceOfMaps& evidence) {
  std::vector<JudgedWay> result;
  for (const Way& way : ways) {
    const auto match = std::find_if(matches.begin(), matches.end(), [&](const PairMatch& m) {
      return m.a == way.a && m.b == way.b;
    });
    const Alignment& pair = match->alignment;
    const bool is_match = evidence.isSame(way.b, way.T_a_b, pair.match.T_a_b);
    result.push_back({way, is_match && evidence.holds(*match) ? pair.evaluation.probability : 0});
  }
  return result;
}

/** Returns pairs that were not matched, and that fix each other's poses in a configuration: the
 * maps meet there and agree. The pair with the most confirmed obstacles comes first. */
std::vector<CandidatePair> unmatchedPairs(const Configuration& c,
                                          const std::vector<PairMatch>& matches,
                                          const TeamEvidence& evidence) {
  std::set<std::pair<size_t, size_t>> matched;
  for (const PairMatch& m : matches) matched.emplace(m.a, m.b);
  std::vector<std::pair<double, CandidatePair>> order;
  for (size_t a = 0; a < c.pose.size(); a++)
    for (size_t b = a + 1; b < c.pose.size(); b++) {
      if (!c.pose[a] || !c.pose[b] || matched.count({a, b})) continue;
      const PairEvidence& e = evidence.near(a, b, c.pose[a]->inverse() * *c.pose[b]);
      if (e.registered) order.push_back({e.confirmed(), {a, b}});
    }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& g, const auto& h) { return g.first > h.first; });
  std::vector<CandidatePair> pairs;
  for (const auto& entry : order) pairs.push_back(entry.second);
  return pairs;
}

/** Returns the most probable match of a map that is not placed with a placed map. */
const PairMatch& bestMatch(size_t k, const std::vector<PairMatch>& matches,
                           const std::vector<PlacedMap>& placed) {
  const PairMatch* best = nullptr;
  for (const PairMatch& m : matches) {
    if ((m.a != k && m.b != k) || !placed[m.a == k ? m.b : m.a].placed) continue;
    if (!best || m.alignment.evaluation.probability > best->alignment.evaluation.probability)
      best = &m;
  }
  return *best;
}

/** Returns the matches of the pairs, and whether the placed maps lie as the matches say. */
std::vector<TeamPair> teamPairs(const std::vector<RobotMap>& maps,
                                const std::vector<PairMatch>& matches,
                                const std::vector<PlacedMap>& placed,
                                const TeamEvidence& evidence) {
  std::vector<TeamPair> pairs;
  for (const PairMatch& m : matches) {
    const Evaluation& e = m.alignment.evaluation;
    const PlacedMap &a = placed[m.a], &b = placed[m.b];
    const bool holds = a.placed && b.placed &&
                       evidence.isSame(m.b, m.alignment.match.T_a_b, a.pose->inverse() * *b.pose);
    pairs.push_back({maps[m.a].robot, maps[m.b].robot, e.accepted, e.is_ambiguous, e.probability,
                     e.overlap, holds});
  }
  return pairs;
}

/** Gives some of the maps the poses that their matches with their partners give, partners first.
 * The partner of a map is placed. */
template <class IsSome>
void follow(const std::vector<size_t>& partner, std::vector<FusionMember>& members,
            const IsSome& is_some) {
  std::vector<size_t> order{0};
  for (size_t next = 0; next < order.size(); next++)
    for (size_t k = 1; k < members.size(); k++) {
      if (partner[k] != order[next]) continue;
      order.push_back(k);
      if (!is_some(k)) continue;
      const auto in_partner = members[k].alignment.pose();
      members[k].pose = partner[k] == 0 ? in_partner : members[partner[k]].pose + in_partner;
    }
}

/** Gives the placed maps the poses at which all their links agree best, with their joint
 * covariance. The first map keeps its pose. */
void optimize(std::vector<FusionMember>& members) {
  std::vector<PoseConstraint> constraints;
  std::vector<std::optional<Eigen::Isometry3d>> poses(members.size());
  for (size_t k = 0; k < members.size(); k++) {
    if (members[k].joined) poses[k] = toEigen(members[k].pose.mean);
    for (const FusionLink& link : members[k].links)
      constraints.push_back(constraintOf(link.with, k, link.T_a_b, link.covariance));
  }
  const std::vector<Matrix6d> covariances = optimizeWithCovariance(constraints, poses);
  for (size_t k = 1; k < members.size(); k++) {
    if (!members[k].joined) continue;
    const Matrix6d covariance = toYawPitchRollCovariance(covariances[k], *poses[k]);
    members[k].pose = {toPose(*poses[k]), mrpt::math::CMatrixDouble66(covariance)};
  }
}

}  // namespace

PlacedTeam placeTeam(const std::vector<RobotMap>& maps, const Options& options,
                     const OnMember& on_member, PairMemory& memory) {
  for (const RobotMap& map : maps)
    withPath(map.robot,
             [&] { ASSERTMSG_(map.map.occupiedVoxels() > 0, "the map has no occupied voxel"); });

  // 1. Pairs: each map with each other map, or with those that look like it.
  ThreadExecutor executor;
  const std::vector<PairMatch> matches = matchPairs(maps, options, executor, on_member, memory);
  return placeByMatches(maps, matches, options, memory);
}

PlacedTeam placeByMatches(const std::vector<RobotMap>& maps, std::vector<PairMatch> matches,
                          const Options& options, PairMemory& memory) {
  ThreadExecutor executor;
  // 2. Graph: the poses in which pairs may lie, and what all pairs say of them.
  JointVerdictParams params;
  params.max_conflict = options.evaluation.max_free_conflict;
  params.max_risk = 1 - options.evaluation.min_probability;
  EvidenceOfMaps evidence(maps, options, memory);
  evidence.adaptTolerance(matches);
  evidence.setSureMatches(matches, params.leastSureProbability(maps.size()));
  const std::vector<Way> ways = waysOf(matches, evidence);

  // 3. Verdict: the maps whose place can be trusted.
  std::vector<std::string> names;
  for (const RobotMap& map : maps) names.push_back(map.robot);
  // Candidates miss some maps that meet: they are matched once it is known where they may lie.
  const auto matchFurther = [&](const Configuration& c) {
    std::vector<CandidatePair> pairs = unmatchedPairs(c, matches, evidence);
    const size_t most = kMatchesPerMap * maps.size();
    pairs.resize(std::min(pairs.size(), most - std::min(most, matches.size())));
    const std::vector<PairMatch> further = matchPairs(maps, pairs, options, executor, {}, memory);
    matches.insert(matches.end(), further.begin(), further.end());
    return judged(waysOf(further, evidence), further, evidence);
  };
  const PlacedGroups groups =
      placeGroups(judged(ways, matches, evidence), evidence, names, params, matchFurther);
  const std::vector<PlacedMap>& placed = groups.maps;

  // 4. Poses: each placed map is registered with its parent, with all voxels. Each other map keeps
  // its best match with a placed map, and follows it.
  std::vector<FusionMember> members(maps.size());
  std::vector<size_t> partner(maps.size(), 0);
  executor.run(maps.size(), [&](size_t k) {
    const PlacedMap& p = placed[k];
    FusionMember& member = members[k];
    member.robot = maps[k].robot;
    member.joined = p.placed;
    if (k == 0) return;
    const PairMatch* match = p.placed ? nullptr : &bestMatch(k, matches, placed);
    partner[k] = p.placed ? *p.parent : match->a == k ? match->b : match->a;
    member.matched_with = maps[partner[k]].robot;
    if (match && match->b == k) {
      member.alignment = match->alignment;
    } else {
      const Eigen::Isometry3d T = match ? match->alignment.match.T_a_b.inverse()
                                        : placed[partner[k]].pose->inverse() * *p.pose;
      const PreparedMap &a = maps[partner[k]].map, &b = maps[k].map;
      member.alignment = memory.registration(a, b, T, [&] { return alignFrom(a, b, T, options); });
    }
    Evaluation& e = member.alignment.evaluation;
    const Eigen::Isometry3d at = *placed[partner[k]].pose * member.alignment.match.T_a_b;
    const bool is_at_its_place = p.pose && evidence.isSame(k, at, *p.pose);
    e.probability =
        is_at_its_place
            ? p.probability
            : std::min(e.probability, params.model.ofAnotherPose(
                                          p.pose ? std::optional(p.probability) : std::nullopt));
    e.accepted = p.placed;
    e.reasons = is_at_its_place || p.placed ? p.reasons : reasonsAtMatch(p, member.matched_with);
    e.reasons_against = p.placed ? 0 : e.reasons.size();
    for (const size_t other : groups.others[k]) member.fits.push_back(maps[other].robot);
    e.runner_up = p.runner_up;
    e.other_poses = OtherPoses::Compared;
    e.is_ambiguous = !p.placed && p.runner_up > params.max_runner_up;
  });
  addLinks(maps, options, placed, matches, evidence, executor, memory, members);
  follow(partner, members, [&](size_t k) { return placed[k].placed; });
  optimize(members);
  follow(partner, members, [&](size_t k) { return !placed[k].placed; });
  std::vector<TeamPair> pairs = teamPairs(maps, matches, placed, evidence);
  return {std::move(members), std::move(pairs), placed};
}

}  // namespace mrpt::fusion
