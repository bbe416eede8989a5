// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Searches the poses of a team at which all pairs of maps agree best. */
#include "fusion_team/graph/configuration.h"

#include <algorithm>
#include <utility>

#include "fusion_team/graph/pose_graph.h"

namespace mrpt::fusion {
namespace {

using Eigen::Isometry3d;

struct Relation {
  const ComparedObstacles *of_i, *of_j;
  bool is_sure;  // a sure match places the maps so
};

/** Returns the evidence of maps \a i and \a j at poses in one frame. */
Relation relationOf(size_t i, const Isometry3d& T_i, size_t j, const Isometry3d& T_j,
                    const TeamEvidence& evidence) {
  if (i < j) {
    const Isometry3d T_i_j = T_i.inverse() * T_j;
    const PairEvidence& e = evidence.near(i, j, T_i_j);
    return {&e.of_a, &e.of_b, evidence.isSure(i, j, T_i_j)};
  }
  const Relation inverse = relationOf(j, T_j, i, T_i, evidence);
  return {inverse.of_j, inverse.of_i, inverse.is_sure};
}

void unite(ObstacleSet& all, const ObstacleSet& more) {
  if (all.empty()) all.resize(more.size());
  for (size_t w = 0; w < more.size(); w++) all[w] |= more[w];
}

/** Obstacles of a map, compared with all other placed maps. */
struct KnownObstacles : ComparedObstacles {
  ObstacleSet explained;  // obstacles in the free space of a map with a sure match
};
void unite(KnownObstacles& all, const ComparedObstacles& more, bool is_sure) {
  unite(all.confirmed, more.confirmed);
  unite(is_sure ? all.explained : all.displaced, more.displaced);
  unite(is_sure ? all.explained : all.contradicted, more.contradicted);
}

/** What the placed maps know about each other, by map. */
using Known = std::vector<KnownObstacles>;

Known knownOf(const Configuration& c, const TeamEvidence& evidence) {
  Known known(c.pose.size());
  for (size_t i = 0; i < c.pose.size(); i++)
    for (size_t j = i + 1; j < c.pose.size(); j++)
      if (c.pose[i] && c.pose[j]) {
        const Relation r = relationOf(i, *c.pose[i], j, *c.pose[j], evidence);
        unite(known[i], *r.of_i, r.is_sure);
        unite(known[j], *r.of_j, r.is_sure);
      }
  return known;
}

double scoreOf(const KnownObstacles& o, size_t map, const TeamEvidence& evidence) {
  const ConflictTolerance tolerance = evidence.tolerance();
  return evidence.areaOfObstacle(map) *
         (countOf(o.confirmed) - countOf(o.displaced) / tolerance.displaced -
          countOf(o.contradicted) / tolerance.contradicted -
          countOf(o.explained) / tolerance.explained);
}

/** Returns the increase of the score by a map. */
double gainOf(size_t k, const Isometry3d& T, const Configuration& c, const Known& known,
              const TeamEvidence& evidence) {
  double gain = 0;
  KnownObstacles of_k;
  for (size_t i = 0; i < c.pose.size(); i++) {
    if (i == k || !c.pose[i]) continue;
    const Relation r = relationOf(i, *c.pose[i], k, T, evidence);
    if (r.of_i->confirmed.empty()) continue;
    KnownObstacles all = known[i];
    unite(all, *r.of_i, r.is_sure);
    gain += scoreOf(all, i, evidence) - scoreOf(known[i], i, evidence);
    unite(of_k, *r.of_j, r.is_sure);
  }
  return gain + scoreOf(of_k, k, evidence);
}

/** A pose at which a map may be placed. */
struct Candidate {
  size_t map;
  Isometry3d T;
};

/** Returns the pose that a way from map \a from gives to the other map of the way. */
Isometry3d poseBy(const Way& way, size_t from, const Isometry3d& T_from) {
  return way.a == from ? T_from * way.T_a_b : T_from * way.T_a_b.inverse();
}

void addCandidates(size_t from, const Configuration& c, const std::vector<Way>& ways,
                   const TeamEvidence& evidence, std::vector<Candidate>& candidates) {
  for (const Way& way : ways) {
    if (way.a != from && way.b != from) continue;
    const size_t map = way.a == from ? way.b : way.a;
    if (c.pose[map]) continue;
    const Isometry3d T = poseBy(way, from, *c.pose[from]);
    const bool is_known = std::any_of(candidates.begin(), candidates.end(), [&](const auto& k) {
      return k.map == map && evidence.isSame(map, k.T, T);
    });
    if (!is_known) candidates.push_back({map, T});
  }
}

/** A choice among candidates. */
struct Choice {
  const Candidate* candidate = nullptr;
  double gain = 0;        // of the candidate
  double preference = 0;  // the choice with the largest preference is placed first
};

/** Returns the candidate to place next, or none if no candidate increases the score. */
Choice bestChoice(const std::vector<Candidate>& candidates, const Configuration& c,
                  const TeamEvidence& evidence, GrowthOrder order) {
  const Known known = knownOf(c, evidence);
  std::vector<Choice> of_map(c.pose.size());
  std::vector<double> second(c.pose.size(), 0);
  for (const Candidate& k : candidates) {
    const double gain = gainOf(k.map, k.T, c, known, evidence);
    Choice& best = of_map[k.map];
    if (gain > best.gain) {
      second[k.map] = best.gain;
      best = {&k, gain, 0};
    } else {
      second[k.map] = std::max(second[k.map], gain);
    }
  }
  Choice best;
  for (size_t k = 0; k < of_map.size(); k++) {
    Choice& choice = of_map[k];
    choice.preference = choice.gain - (order == GrowthOrder::Clearest ? second[k] : 0);
    if (choice.candidate && (!best.candidate || choice.preference > best.preference)) best = choice;
  }
  return best;
}

/** Places candidates one after another while the score grows. */
void grow(Configuration& c, const std::vector<Way>& ways, const TeamEvidence& evidence,
          GrowthOrder order) {
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < c.pose.size(); i++)
    if (c.pose[i]) addCandidates(i, c, ways, evidence, candidates);
  while (true) {
    const Choice choice = bestChoice(candidates, c, evidence, order);
    if (!choice.candidate) return;
    const Candidate next = *choice.candidate;
    c.pose[next.map] = next.T;
    c.score += choice.gain;
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(),
                                    [&](const auto& k) { return k.map == next.map; }),
                     candidates.end());
    addCandidates(next.map, c, ways, evidence, candidates);
  }
}

}  // namespace

void settle(Configuration& c, const TeamEvidence& evidence) {
  constexpr size_t kMostRounds = 4;        // the evidence changes with the poses
  constexpr double kLeastConfirmed = 100;  // a pair with fewer obstacles fixes no pose
  for (size_t round = 0; round < kMostRounds; round++) {
    std::vector<PoseConstraint> constraints;
    for (size_t i = 0; i < c.pose.size(); i++)
      for (size_t j = i + 1; j < c.pose.size(); j++) {
        if (!c.pose[i] || !c.pose[j]) continue;
        const PairEvidence& e = evidence.near(i, j, c.pose[i]->inverse() * *c.pose[j]);
        if (e.confirmed() >= kLeastConfirmed) constraints.push_back({i, j, e.registered});
      }
    Configuration settled = c;
    optimizePoses(constraints, settled.pose);
    settled.score = scoreOf(settled, evidence);
    if (settled.score <= c.score) return;
    c = std::move(settled);
  }
}

TeamAreas areasOf(size_t k, const Configuration& c, const TeamEvidence& evidence) {
  TeamAreas areas;
  const auto add = [&](const KnownObstacles& of_map, size_t map) {
    const double area = evidence.areaOfObstacle(map);
    areas.confirmed += area * countOf(of_map.confirmed);
    areas.displaced += area * countOf(of_map.displaced);
    areas.contradicted += area * countOf(of_map.contradicted);
    areas.explained += area * countOf(of_map.explained);
  };
  KnownObstacles of_k;
  for (size_t i = 0; i < c.pose.size(); i++) {
    if (i == k || !c.pose[i]) continue;
    const Relation r = relationOf(i, *c.pose[i], k, *c.pose[k], evidence);
    unite(of_k, *r.of_j, r.is_sure);
    KnownObstacles of_i;
    unite(of_i, *r.of_i, r.is_sure);
    add(of_i, i);
  }
  add(of_k, k);
  return areas;
}

double scoreOf(const Configuration& c, const TeamEvidence& evidence) {
  const Known known = knownOf(c, evidence);
  double sum = 0;
  for (size_t k = 0; k < known.size(); k++) sum += scoreOf(known[k], k, evidence);
  return sum;
}

Configuration pairOf(const Way& way, const TeamEvidence& evidence) {
  Configuration c;
  c.pose.resize(evidence.size());
  c.pose[way.a] = Isometry3d::Identity();
  c.pose[way.b] = way.T_a_b;
  c.score = scoreOf(c, evidence);
  return c;
}

Configuration grownFrom(const Way& seed, const std::vector<Way>& ways, const TeamEvidence& evidence,
                        GrowthOrder order) {
  Configuration c = pairOf(seed, evidence);
  grow(c, ways, evidence, order);
  return c;
}

void improve(Configuration& c, const std::vector<Way>& ways, const TeamEvidence& evidence,
             Moves moves) {
  constexpr double kLeastGain = 1e-6;  // share of the score
  const auto replaced = [&](const std::vector<size_t>& maps, GrowthOrder order) {
    Configuration moved = c;
    for (const size_t k : maps) moved.pose[k].reset();
    moved.score = scoreOf(moved, evidence);
    grow(moved, ways, evidence, order);
    if (moved.score <= c.score * (1 + kLeastGain)) return false;
    c = std::move(moved);
    return true;
  };
  for (bool is_better = true; is_better;) {
    is_better = false;
    for (size_t i = 0; i < c.pose.size(); i++)
      for (size_t j = i; j < (moves == Moves::OfOneMap ? i + 1 : c.pose.size()); j++)
        for (const GrowthOrder order : {GrowthOrder::LargestGain, GrowthOrder::Clearest})
          if (c.pose[i] && c.pose[j]) is_better |= replaced({i, j}, order);
  }
}

}  // namespace mrpt::fusion
