// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Searches the best configuration of a team, and its rivals. */
#include "fusion_team/graph/team_search.h"

#include <algorithm>
#include <utility>

#include "fusion_team/graph/configuration.h"

namespace mrpt::fusion {
namespace {

using Eigen::Isometry3d;

bool scoresBetter(const Configuration& g, const Configuration& h) { return g.score > h.score; }

/** Returns the best way of each pair, best score first. */
std::vector<Way> bestOf(const std::vector<Way>& ways, const TeamEvidence& evidence, size_t most) {
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < ways.size(); i++) order.emplace_back(-pairOf(ways[i], evidence).score, i);
  std::sort(order.begin(), order.end());
  std::vector<Way> best;
  for (const auto& [score, i] : order) {
    const Way& way = ways[i];
    const bool has_pair = std::any_of(best.begin(), best.end(), [&](const Way& other) {
      return other.a == way.a && other.b == way.b;
    });
    if (!has_pair && best.size() < most) best.push_back(way);
  }
  return best;
}

/** Returns the maps that two configurations place differently: all maps but the largest set of maps
 * with the same poses among themselves. A map that \a other does not place is not placed
 * differently. */
std::vector<size_t> movedMaps(const Configuration& best, const Configuration& other,
                              const TeamEvidence& evidence) {
  const size_t n = best.pose.size();
  std::vector<size_t> fewest;
  size_t most_same = 0;
  for (size_t root = 0; root < n; root++) {
    if (!best.pose[root] || !other.pose[root]) continue;
    const Isometry3d T = *best.pose[root] * other.pose[root]->inverse();
    std::vector<size_t> moved;
    size_t same = 0;
    for (size_t k = 0; k < n; k++) {
      if (!best.pose[k] || !other.pose[k]) continue;
      if (evidence.isSame(k, *best.pose[k], T * *other.pose[k]))
        same++;
      else
        moved.push_back(k);
    }
    if (same > most_same) {
      most_same = same;
      fewest = std::move(moved);
    }
  }
  return fewest;
}

Configuration without(const Configuration& c, const std::vector<size_t>& maps,
                      const TeamEvidence& evidence) {
  Configuration rest = c;
  for (const size_t k : maps) rest.pose[k].reset();
  rest.score = scoreOf(rest, evidence);
  return rest;
}

/** Raises the runner-up of the maps that a rival places differently. */
void compareWith(const Configuration& rival, const TeamEvidence& evidence,
                 TeamSearchResult& result) {
  const std::vector<size_t> moved = movedMaps(result.best, rival, evidence);
  if (moved.empty()) return;
  const double gain = result.best.score - without(result.best, moved, evidence).score;
  const double gain_of_rival = rival.score - without(rival, moved, evidence).score;
  if (gain_of_rival <= 0) return;
  const double ratio = gain > 0 ? gain_of_rival / gain : 2;
  for (const size_t k : moved) result.runner_up[k] = std::max(result.runner_up[k], ratio);
}

/** Compares the best configuration with other places of a block of maps that keeps its shape. */
void compareWithOtherPlaces(const std::vector<size_t>& block, const std::vector<Way>& ways,
                            const TeamEvidence& evidence, TeamSearchResult& result) {
  const Configuration rest = without(result.best, block, evidence);
  const auto in_block = [&](size_t k) {
    return std::find(block.begin(), block.end(), k) != block.end();
  };
  std::vector<Isometry3d> tried;
  for (const Way& way : ways) {
    const bool a_in = in_block(way.a), b_in = in_block(way.b);
    const size_t inside = a_in ? way.a : way.b, outside = a_in ? way.b : way.a;
    if (a_in == b_in || !rest.pose[outside] || !result.best.pose[inside]) continue;
    const Isometry3d T = *rest.pose[outside] * (a_in ? way.T_a_b.inverse() : way.T_a_b);
    if (evidence.isSame(inside, T, *result.best.pose[inside])) continue;
    const Isometry3d motion = T * result.best.pose[inside]->inverse();
    const size_t first = block.front();
    const Isometry3d T_first = motion * *result.best.pose[first];
    if (std::any_of(tried.begin(), tried.end(),
                    [&](const Isometry3d& U) { return evidence.isSame(first, T_first, U); }))
      continue;
    tried.push_back(T_first);
    Configuration rival = rest;
    for (const size_t k : block) rival.pose[k] = motion * *result.best.pose[k];
    rival.score = scoreOf(rival, evidence);
    compareWith(rival, evidence, result);
  }
}

}  // namespace

TeamSearchResult searchTeam(const std::vector<Way>& ways, const TeamEvidence& evidence,
                            size_t most_starts) {
  TeamSearchResult result;
  result.runner_up.resize(evidence.size());
  result.best.pose.resize(evidence.size());
  if (ways.empty()) return result;

  std::vector<Configuration> grown;
  for (const Way& seed : bestOf(ways, evidence, most_starts))
    for (const GrowthOrder order : {GrowthOrder::LargestGain, GrowthOrder::Clearest}) {
      grown.push_back(grownFrom(seed, ways, evidence, order));
      settle(grown.back(), evidence);
    }
  std::stable_sort(grown.begin(), grown.end(), scoresBetter);
  constexpr size_t kMostImproved = 8;
  for (size_t i = 0; i < std::min(kMostImproved, grown.size()); i++) {
    Configuration c = grown[i];
    improve(c, ways, evidence);
    settle(c, evidence);
    grown.push_back(std::move(c));
  }
  result.best = *std::min_element(grown.begin(), grown.end(), scoresBetter);

  for (const Configuration& rival : grown) compareWith(rival, evidence, result);
  const size_t n = evidence.size();
  for (size_t k = 0; k < n; k++)
    if (result.best.pose[k]) compareWithOtherPlaces({k}, ways, evidence, result);
  for (const Way& way : ways) {
    const auto &T_a = result.best.pose[way.a], &T_b = result.best.pose[way.b];
    if (T_a && T_b && evidence.isSame(way.b, *T_a * way.T_a_b, *T_b))
      compareWithOtherPlaces({way.a, way.b}, ways, evidence, result);
  }
  return result;
}

}  // namespace mrpt::fusion
