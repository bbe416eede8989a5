// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Searches the best configuration of a team, and its rivals. */
#include "fusion_team/graph/team_search.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "fusion_team/graph/configuration.h"
#include "fusion_team/graph/other_places.h"
#include "fusion_team/graph/rigid_groups.h"
#include "fusion_team/graph/scored_team.h"

namespace mrpt::fusion {
namespace {

using Eigen::Isometry3d;

constexpr size_t kMostMoved = 32;     // configurations that moves of one map improve
constexpr size_t kMostImproved = 16;  // configurations that are improved further
constexpr size_t kMostTried = 8;      // other places of blocks that moves improve
constexpr size_t kManyMaps = 20;      // with more maps, fewer configurations are grown and improved

/** Returns the number of configurations for a team of \a n maps: the cost of a configuration grows
 * with its maps, and those of a large team share most of their places. */
size_t countFor(size_t n, size_t most) {
  constexpr size_t kLeast = 2;
  return n <= kManyMaps ? most : std::max(kLeast, most * kManyMaps / n);
}

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

/** Returns the number of sure matches whose maps lie as the match says in the best configuration,
 * but not in another configuration. */
size_t partedMatches(const Configuration& best, const Configuration& other,
                     const TeamEvidence& evidence) {
  size_t n = 0;
  for (size_t a = 0; a < best.pose.size(); a++)
    for (size_t b = a + 1; b < best.pose.size(); b++) {
      if (!best.pose[a] || !best.pose[b] || !other.pose[a] || !other.pose[b]) continue;
      const auto T = evidence.sureMatch(a, b);
      if (T && evidence.isSame(b, best.pose[a]->inverse() * *best.pose[b], *T) &&
          !evidence.isSame(b, other.pose[a]->inverse() * *other.pose[b], *T))
        n++;
    }
  return n;
}

/** Returns the score that connects the rigid groups of a rival of the best configuration. One sure
 * match alone may be wrong: it does not refute a rival. */
double connectingScore(const Configuration& rival, const Configuration& best,
                       const std::vector<std::vector<size_t>>& groups,
                       const TeamEvidence& evidence) {
  const bool counts_denied = partedMatches(best, rival, evidence) > 1;
  const auto scoreOfMaps = [&](const Configuration& c) {
    return c.score + (counts_denied ? 0 : ScoredTeam(c, evidence).deniedArea());
  };
  double score = scoreOfMaps(rival);
  for (const auto& group : groups) score -= scoreOfMaps(with(rival, group, evidence));
  return score;
}

/** Raises the runner-up of the maps that a rival places differently in the frame of the first map.
 * What connects the rigid groups counts, not what the maps of a group say about each other: both
 * configurations share it. A rival that gains much is settled before it counts: else the best
 * configuration with the errors of a chain of maps would be its own rival. */
void compareWith(const Configuration& rival, const TeamEvidence& evidence, TeamSearchResult& result,
                 bool is_settled = false) {
  constexpr double kWorthSettling = 0.5;  // gain over the gain of the place
  const auto groups = rigidGroups(result.best, rival, evidence);
  if (groups.size() < 2) return;
  double apart = 0;
  std::vector<size_t> moved;
  for (size_t i = 1; i < groups.size(); i++) {
    apart += with(result.best, groups[i], evidence).score;
    moved.insert(moved.end(), groups[i].begin(), groups[i].end());
  }
  // A map that the rival does not place stays with the largest group.
  apart += without(result.best, moved, evidence).score;
  const double gain = result.best.score - apart;
  const double gain_of_rival = connectingScore(rival, result.best, groups, evidence);
  if (gain_of_rival <= 0) return;
  const double ratio = gain > 0 ? gain_of_rival / gain : 2;
  if (!is_settled && ratio > kWorthSettling) {
    Configuration settled = rival;
    settle(settled, evidence);
    return compareWith(settled, evidence, result, true);
  }
  const auto with_first = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
    return std::find(group.begin(), group.end(), result.first) != group.end();
  });
  const size_t stays = with_first == groups.end() ? 0 : size_t(with_first - groups.begin());
  for (size_t i = 0; i < groups.size(); i++)
    if (i != stays)
      for (const size_t k : groups[i]) result.runner_up[k] = std::max(result.runner_up[k], ratio);
}

/** True if two configurations place the same maps, and all of them as one rigid group. */
bool isSame(const Configuration& c, const Configuration& d, const TeamEvidence& evidence) {
  std::vector<size_t> maps;
  for (size_t k = 0; k < c.pose.size(); k++) {
    if (c.pose[k].has_value() != d.pose[k].has_value()) return false;
    if (c.pose[k]) maps.push_back(k);
  }
  // Most roots differ in the map that the root before has shown to differ: it comes first.
  const std::vector<size_t> roots = maps;
  return std::any_of(roots.begin(), roots.end(), [&](size_t root) {
    const Isometry3d T = *c.pose[root] * d.pose[root]->inverse();
    const auto differs = std::find_if(maps.begin(), maps.end(), [&](size_t k) {
      return k != root && !evidence.isSame(k, *c.pose[k], T * *d.pose[k]);
    });
    if (differs == maps.end()) return true;
    std::swap(maps.front(), *differs);
    return false;
  });
}

/** Sorts configurations, best score first, and keeps the best of each that are the same, in all at
 * most \a most. */
void keepDistinct(std::vector<Configuration>& configurations, size_t most,
                  const TeamEvidence& evidence) {
  std::stable_sort(configurations.begin(), configurations.end(), scoresBetter);
  std::vector<Configuration> distinct;
  for (Configuration& c : configurations)
    if (distinct.size() < most &&
        std::none_of(distinct.begin(), distinct.end(),
                     [&](const Configuration& d) { return isSame(c, d, evidence); }))
      distinct.push_back(std::move(c));
  configurations = std::move(distinct);
}

/** Improves the best of some rivals of a configuration. \return A configuration with a larger
 * score, if there is one. */
std::optional<Configuration> betterThan(const Configuration& best,
                                        std::vector<Configuration> rivals, const TeamWays& ways,
                                        const TeamEvidence& evidence) {
  constexpr double kLeastGain = 1e-6;  // share of the score
  keepDistinct(rivals, kMostTried, evidence);
  for (Configuration& rival : rivals) {
    improve(rival, ways, evidence, Moves::OfOneMap);
    settle(rival, evidence);
    if (rival.score > best.score * (1 + kLeastGain)) return rival;
  }
  return std::nullopt;
}

/** Grows configurations from the best ways. Each map is in one of them. */
std::vector<Configuration> grownFromBest(const TeamWays& ways, const TeamEvidence& evidence,
                                         size_t most_starts) {
  std::vector<Configuration> grown;
  std::vector<bool> is_placed(ways.n());
  const std::vector<Way> seeds = bestOf(ways.all, evidence);
  for (size_t i = 0; i < seeds.size(); i++) {
    // The best seeds lead to the best configurations.
    if (i >= countFor(ways.n(), most_starts) && is_placed[seeds[i].a] && is_placed[seeds[i].b])
      continue;
    for (const GrowthOrder order : {GrowthOrder::LargestGain, GrowthOrder::Clearest}) {
      grown.push_back(grownFrom(seeds[i], ways, evidence, order));
      for (size_t k = 0; k < ways.n(); k++)
        if (grown.back().pose[k]) is_placed[k] = true;
    }
  }
  return grown;
}

/** Crosses one of some configurations with the others while that makes it better. */
void cross(size_t one, std::vector<Configuration>& all, const TeamWays& ways,
           const TeamEvidence& evidence) {
  for (std::optional<Configuration> better(all[one]); better;) {
    all[one] = std::move(*better);
    std::vector<Configuration> rivals;
    for (size_t k = 0; k < all.size(); k++) {
      if (k == one) continue;
      std::vector<Configuration> more = crossed(all[one], all[k], evidence);
      std::move(more.begin(), more.end(), std::back_inserter(rivals));
    }
    better = betterThan(all[one], std::move(rivals), ways, evidence);
  }
}

/** Searches the best configuration and its rivals from some configurations. */
TeamSearchResult searchFrom(std::vector<Configuration> found, const TeamWays& ways,
                            const TeamEvidence& evidence, size_t first) {
  const size_t n = ways.n();
  TeamSearchResult result;
  result.first = first;
  result.runner_up.resize(n);
  keepDistinct(found, countFor(n, kMostMoved), evidence);
  for (Configuration& c : found) improve(c, ways, evidence, Moves::OfOneMap);
  keepDistinct(found, countFor(n, kMostMoved), evidence);
  // The steps that follow, and the cost of each, grow with the maps.
  const size_t most_improved = countFor(n, countFor(n, kMostImproved));
  for (size_t i = 0; i < std::min(most_improved, found.size()); i++)
    cross(i, found, ways, evidence);
  keepDistinct(found, found.size(), evidence);
  const auto improveFurther = [&](Configuration& c) {
    settle(c, evidence);
    improve(c, ways, evidence, Moves::OfOneOrTwo);
    settle(c, evidence);
  };
  for (size_t i = 0; i < std::min(most_improved, found.size()); i++) improveFurther(found[i]);
  const auto best = std::min_element(found.begin(), found.end(), scoresBetter);
  result.best = *best;
  found.erase(best);
  std::vector<Configuration> rivals = otherPlaces(result.best, ways, evidence);
  while (auto better = betterThan(result.best, rivals, ways, evidence)) {
    improveFurther(*better);
    found.push_back(std::exchange(result.best, std::move(*better)));
    rivals = otherPlaces(result.best, ways, evidence);
  }
  for (const auto* others : {&found, &rivals})
    for (const Configuration& rival : *others) compareWith(rival, evidence, result);
  std::stable_sort(found.begin(), found.end(), scoresBetter);
  result.others = std::move(found);
  return result;
}

}  // namespace

TeamSearchResult searchTeam(const std::vector<Way>& ways, const TeamEvidence& evidence,
                            size_t most_starts, size_t first) {
  const TeamWays of_team(ways, evidence.size());
  std::vector<Configuration> grown = grownFromBest(of_team, evidence, most_starts);
  if (grown.empty()) grown.emplace_back().pose.resize(evidence.size());
  return searchFrom(std::move(grown), of_team, evidence, first);
}

TeamSearchResult searchAgain(const TeamSearchResult& before, const std::vector<Way>& ways,
                             const TeamEvidence& evidence, const std::vector<size_t>& left_out) {
  std::vector<Configuration> rest{without(before.best, left_out, evidence)};
  for (const Configuration& c : before.others) rest.push_back(without(c, left_out, evidence));
  return searchFrom(std::move(rest), TeamWays(ways, evidence.size()), evidence, before.first);
}

}  // namespace mrpt::fusion
