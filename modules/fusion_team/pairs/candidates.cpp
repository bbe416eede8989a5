// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Chooses the pairs of a team that are matched. */
#include "fusion_team/pairs/candidates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_core/features/features.h"
#include "fusion_core/pair/align_from.h"
#include "fusion_core/pair/scaled_options.h"
#include "fusion_team/pairs/pair_prior.h"

namespace mrpt::fusion {
namespace {

/** True if map B can meet map A within the search that follows from a prior. \a a,b: the boxes of
 * the maps, in their frames. */
bool mayMeet(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b, const Prior& prior,
             const SearchParams& configured) {
  const SearchParams search = prior.searchWithin(configured);
  if (prior.isNone() || search.isEverywhere()) return true;
  const double radius = 0.5 * b.diagonal().norm();
  const double beside = search.translation + std::min(search.yaw, M_PI) * radius;
  const Eigen::Vector3d reach(beside, beside, search.height + beside);
  const Eigen::AlignedBox3d reached(a.min() - reach, a.max() + reach);
  return reached.intersects(b.transformed(toEigen(prior.guess())));
}

/** Returns all pairs, sorted by b, then by a. */
std::vector<CandidatePair> allPairs(size_t n) {
  std::vector<CandidatePair> pairs;
  for (size_t b = 0; b < n; b++)
    for (size_t a = 0; a < b; a++) pairs.push_back({a, b});
  return pairs;
}

/** Returns for each map the other maps of its pairs, largest agreement first.
 * \param[in] agreements Agreement of each pair. */
std::vector<std::vector<size_t>> partnersOf(size_t n, const std::vector<CandidatePair>& pairs,
                                            const std::vector<double>& agreements) {
  std::vector<size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t g, size_t h) { return agreements[g] > agreements[h]; });
  std::vector<std::vector<size_t>> partners(n);
  for (const size_t i : order) {
    partners[pairs[i].a].push_back(pairs[i].b);
    partners[pairs[i].b].push_back(pairs[i].a);
  }
  return partners;
}

}  // namespace

std::vector<CandidatePair> candidatePairs(const std::vector<RobotMap>& maps, const Options& options,
                                          Executor& executor, PairMemory& memory) {
  const size_t n = maps.size(), most = (kMatchesPerMap - kLaterMatchesPerMap) * n;
  if (n * (n - 1) / 2 <= kMatchesPerMap * n) return allPairs(n);

  double scale = 0;
  for (const RobotMap& map : maps) scale = std::max(scale, map.map.scale());
  const SearchParams search = scaledBy(options, scale).search;
  std::vector<Eigen::AlignedBox3d> box(n);
  executor.run(n, [&](size_t k) { box[k] = boxOf(maps[k].map.features()); });
  std::vector<CandidatePair> possible;
  for (const auto& [a, b] : allPairs(n))
    if (mayMeet(box[a], box[b], priorOf(maps[b], maps[a]), search)) possible.push_back({a, b});
  std::vector<double> agreements(possible.size());
  executor.run(possible.size(), [&](size_t i) {
    const RobotMap &a = maps[possible[i].a], &b = maps[possible[i].b];
    withPath(b.robot, [&] {
      const Prior prior = priorOf(b, a);
      agreements[i] = memory.agreement(
          a.map, b.map, prior, [&] { return coarseAgreement(a.map, b.map, prior, options); });
    });
  });

  // The best partner of each map comes first, then the second best partner, and so on.
  const auto partners = partnersOf(n, possible, agreements);
  std::set<std::pair<size_t, size_t>> chosen;  // b, a
  for (size_t b = 1; b < n; b++) chosen.emplace(b, 0);
  for (size_t rank = 0; rank < n; rank++)
    for (size_t k = 0; k < n; k++)
      if (rank < partners[k].size() && chosen.size() < most)
        chosen.emplace(std::max(k, partners[k][rank]), std::min(k, partners[k][rank]));
  std::vector<CandidatePair> pairs;
  for (const auto& [b, a] : chosen) pairs.push_back({a, b});
  return pairs;
}

}  // namespace mrpt::fusion
