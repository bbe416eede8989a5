// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Searches the best configuration of a team, and its rivals. */
#include "fusion_team/graph/team_search.h"

#include <algorithm>
#include <set>
#include <utility>

#include "fusion_team/graph/configuration.h"
#include "fusion_team/graph/scored_team.h"

namespace mrpt::fusion {
namespace {

using Eigen::Isometry3d;

constexpr size_t kMostMoved = 32;       // configurations that moves of one map improve
constexpr size_t kMostImproved = 16;    // configurations that moves of two maps improve
constexpr double kWorthSettling = 0.8;  // least share of the best score, of a rival

bool scoresBetter(const Configuration& g, const Configuration& h) { return g.score > h.score; }

/** Returns the best way of each pair, best score first. */
std::vector<Way> bestOf(const std::vector<Way>& ways, const TeamEvidence& evidence) {
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < ways.size(); i++) order.emplace_back(-pairOf(ways[i], evidence).score, i);
  std::sort(order.begin(), order.end());
  std::vector<Way> best;
  std::set<std::pair<size_t, size_t>> pairs;
  for (const auto& [score, i] : order)
    if (pairs.emplace(ways[i].a, ways[i].b).second) best.push_back(ways[i]);
  return best;
}

/** Divides the maps that two configurations place into rigid groups: within a group both
 * configurations have the same poses. The largest group comes first. */
std::vector<std::vector<size_t>> rigidGroups(const Configuration& best, const Configuration& other,
                                             const TeamEvidence& evidence) {
  std::vector<size_t> open;
  for (size_t k = 0; k < best.pose.size(); k++)
    if (best.pose[k] && other.pose[k]) open.push_back(k);
  std::vector<std::vector<size_t>> groups;
  while (!open.empty()) {
    std::vector<size_t> largest;
    for (const size_t root : open) {
      const Isometry3d T = *best.pose[root] * other.pose[root]->inverse();
      std::vector<size_t> same;
      for (const size_t k : open)
        if (k == root || evidence.isSame(k, *best.pose[k], T * *other.pose[k])) same.push_back(k);
      if (same.size() > largest.size()) largest = std::move(same);
    }
    for (const size_t k : largest) open.erase(std::find(open.begin(), open.end(), k));
    groups.push_back(std::move(largest));
  }
  return groups;
}

Configuration with(const Configuration& c, const std::vector<size_t>& maps,
                   const TeamEvidence& evidence) {
  Configuration some;
  some.pose.resize(c.pose.size());
  for (const size_t k : maps) some.pose[k] = c.pose[k];
  some.score = scoreOf(some, evidence);
  return some;
}

Configuration without(const Configuration& c, const std::vector<size_t>& maps,
                      const TeamEvidence& evidence) {
  Configuration rest = c;
  for (const size_t k : maps) rest.pose[k].reset();
  rest.score = scoreOf(rest, evidence);
  return rest;
}

/** Raises the runner-up of the maps that a rival places differently in the frame of the first map.
 * What connects the rigid groups counts, not what the maps of a group say about each other: both
 * configurations share it. */
void compareWith(const Configuration& rival, const TeamEvidence& evidence,
                 TeamSearchResult& result) {
  const auto groups = rigidGroups(result.best, rival, evidence);
  if (groups.size() < 2) return;
  double apart = 0, apart_of_rival = 0;
  std::vector<size_t> moved;
  for (size_t i = 0; i < groups.size(); i++) {
    apart_of_rival += with(rival, groups[i], evidence).score;
    if (i == 0) continue;
    apart += with(result.best, groups[i], evidence).score;
    moved.insert(moved.end(), groups[i].begin(), groups[i].end());
  }
  // A map that the rival does not place stays with the largest group.
  apart += without(result.best, moved, evidence).score;
  const double gain = result.best.score - apart;
  const double gain_of_rival = rival.score - apart_of_rival;
  if (gain_of_rival <= 0) return;
  const double ratio = gain > 0 ? gain_of_rival / gain : 2;
  const auto with_first = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
    return std::find(group.begin(), group.end(), result.first) != group.end();
  });
  const size_t stays = with_first == groups.end() ? 0 : size_t(with_first - groups.begin());
  for (size_t i = 0; i < groups.size(); i++)
    if (i != stays)
      for (const size_t k : groups[i]) result.runner_up[k] = std::max(result.runner_up[k], ratio);
}

bool isSame(const Configuration& c, const Configuration& d, const TeamEvidence& evidence) {
  for (size_t k = 0; k < c.pose.size(); k++)
    if (c.pose[k].has_value() != d.pose[k].has_value()) return false;
  return rigidGroups(c, d, evidence).size() == 1;
}

/** Sorts configurations, best score first, and keeps the best of each that are the same. */
void keepDistinct(std::vector<Configuration>& configurations, const TeamEvidence& evidence) {
  std::stable_sort(configurations.begin(), configurations.end(), scoresBetter);
  std::vector<Configuration> distinct;
  for (Configuration& c : configurations)
    if (std::none_of(distinct.begin(), distinct.end(),
                     [&](const Configuration& d) { return isSame(c, d, evidence); }))
      distinct.push_back(std::move(c));
  configurations = std::move(distinct);
}

/** Returns what maps that keep their shape gain by joining a team: the increase of the score, less
 * the score of these maps alone. A value of at most 0 is not exact.
 * \param[in] first,second The maps at their poses; the second may be missing. */
double joiningGain(ScoredTeam& team, const Placement& first, const Placement* second,
                   double alone) {
  if (!second) return Addition(first.map, first.T, team).gain(team);
  const Addition bound(second->map, second->T, team);
  const double least = alone - bound.mostGain(team) - team.evidence().areaOf(first.map);
  const double gain = Addition(first.map, first.T, team, least).gain(team);
  if (gain <= least) return 0;
  team.place(first.map, first.T);
  const double more = Addition(second->map, second->T, team, alone - gain).gain(team);
  team.remove(first.map);
  return gain + more - alone;
}

/** Compares the best configuration with other places of one or two maps that keep their shape. */
void compareWithOtherPlaces(const std::vector<size_t>& block, const TeamWays& ways,
                            const TeamEvidence& evidence, TeamSearchResult& result) {
  constexpr double kWorthwhile = 0.5;  // least gain over the gain of the place, of a rival
  const auto& best = result.best.pose;
  const auto in_block = [&](size_t k) {
    return std::find(block.begin(), block.end(), k) != block.end();
  };
  ScoredTeam rest(result.best, evidence);
  for (const size_t k : block) rest.remove(k);
  const double alone = block.size() < 2 ? 0 : with(result.best, block, evidence).score;
  const double gain = result.best.score - rest.score() - alone;
  std::vector<Isometry3d> tried;
  for (const size_t inside : block)
    for (const size_t w : ways.of[inside]) {
      const Way& way = ways.all[w];
      const size_t outside = way.a == inside ? way.b : way.a;
      if (in_block(outside) || !best[outside]) continue;
      const Isometry3d T = *best[outside] * (way.a == inside ? way.T_a_b.inverse() : way.T_a_b);
      if (evidence.isSame(inside, T, *best[inside])) continue;
      const Isometry3d motion = T * best[inside]->inverse();
      const Placement first{block.front(), motion * *best[block.front()]};
      if (std::any_of(tried.begin(), tried.end(),
                      [&](const Isometry3d& U) { return evidence.isSame(first.map, first.T, U); }))
        continue;
      tried.push_back(first.T);
      const Placement second{block.back(), motion * *best[block.back()]};
      const double gain_of_rival =
          joiningGain(rest, first, block.size() < 2 ? nullptr : &second, alone);
      if (gain_of_rival <= 0) continue;
      Configuration rival = result.best;
      for (const size_t k : block) rival.pose[k] = motion * *best[k];
      rival.score = rest.score() + alone + gain_of_rival;
      if (rival.score > kWorthSettling * result.best.score && gain_of_rival > kWorthwhile * gain)
        settle(rival, evidence);
      compareWith(rival, evidence, result);
    }
}

}  // namespace

TeamSearchResult searchTeam(const std::vector<Way>& all_ways, const TeamEvidence& evidence,
                            size_t most_starts, size_t first) {
  TeamSearchResult result;
  result.first = first;
  result.runner_up.resize(evidence.size());
  result.best.pose.resize(evidence.size());
  if (all_ways.empty()) return result;

  const TeamWays ways(all_ways, evidence.size());
  std::vector<Configuration> grown;
  std::vector<bool> is_placed(evidence.size());
  const std::vector<Way> seeds = bestOf(all_ways, evidence);
  for (size_t i = 0; i < seeds.size(); i++) {
    // The best seeds lead to the best configurations. Each map is in one of them.
    if (i >= most_starts && is_placed[seeds[i].a] && is_placed[seeds[i].b]) continue;
    for (const GrowthOrder order : {GrowthOrder::LargestGain, GrowthOrder::Clearest}) {
      grown.push_back(grownFrom(seeds[i], ways, evidence, order));
      for (size_t k = 0; k < ways.n(); k++)
        if (grown.back().pose[k]) is_placed[k] = true;
    }
  }
  keepDistinct(grown, evidence);
  if (grown.size() > kMostMoved) grown.resize(kMostMoved);
  for (Configuration& c : grown) improve(c, ways, evidence, Moves::OfOneMap);
  keepDistinct(grown, evidence);
  for (size_t i = 0; i < std::min(kMostImproved, grown.size()); i++) {
    settle(grown[i], evidence);
    improve(grown[i], ways, evidence, Moves::OfOneOrTwo);
    settle(grown[i], evidence);
  }
  result.best = *std::min_element(grown.begin(), grown.end(), scoresBetter);

  for (const Configuration& rival : grown) compareWith(rival, evidence, result);
  const size_t n = evidence.size();
  for (size_t k = 0; k < n; k++)
    if (result.best.pose[k]) compareWithOtherPlaces({k}, ways, evidence, result);
  for (const Way& way : all_ways) {
    const auto &T_a = result.best.pose[way.a], &T_b = result.best.pose[way.b];
    if (T_a && T_b && evidence.isSame(way.b, *T_a * way.T_a_b, *T_b))
      compareWithOtherPlaces({way.a, way.b}, ways, evidence, result);
  }
  return result;
}

}  // namespace mrpt::fusion
