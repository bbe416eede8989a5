// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Chooses the pairs of a team that are matched. */
#include "fusion_team/pairs/candidates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "fusion_core/features/features.h"
#include "fusion_core/pair/scaled_options.h"
#include "fusion_team/pairs/pair_prior.h"
#include "fusion_team/pairs/signature.h"

namespace mrpt::fusion {
namespace {

Eigen::AlignedBox3d boxOf(const RobotMap& map) {
  Eigen::AlignedBox3d box;
  for (const auto& p : map.map.features().matched.voxels.centre) box.extend(p.cast<double>());
  return box;
}

/** What the choice needs of a map. */
struct Candidate {
  Signature signature;
  Eigen::AlignedBox3d box;  // of the map, in its frame
};

/** True if map B can meet map A within the search that follows from a prior. */
bool mayMeet(const Candidate& a, const Candidate& b, const Prior& prior,
             const SearchParams& configured) {
  const SearchParams search = prior.searchWithin(configured);
  if (prior.isNone() || search.isEverywhere()) return true;
  const double radius = 0.5 * b.box.diagonal().norm();
  const double beside = search.translation + std::min(search.yaw, M_PI) * radius;
  const Eigen::Vector3d reach(beside, beside, search.height + beside);
  const Eigen::AlignedBox3d reached(a.box.min() - reach, a.box.max() + reach);
  return reached.intersects(b.box.transformed(toEigen(prior.guess())));
}

/** Returns the share of the surroundings of a map that vote for each of the other maps: each
 * surrounding votes for kMatchesPerMap maps. */
std::vector<double> votesOf(size_t map, const std::vector<Candidate>& all,
                            const std::vector<bool>& may_meet) {
  std::vector<size_t> others;
  for (size_t k = 0; k < all.size(); k++)
    if (may_meet[k] && all[k].signature.cols() > 0) others.push_back(k);
  const Signature& of_map = all[map].signature;
  Eigen::MatrixXf similarity(of_map.cols(), static_cast<Eigen::Index>(others.size()));
  for (size_t i = 0; i < others.size(); i++)
    similarity.col(static_cast<Eigen::Index>(i)) =
        (of_map.transpose() * all[others[i]].signature).rowwise().maxCoeff();

  std::vector<double> votes(all.size(), 0);
  const size_t elected = std::min(kMatchesPerMap, others.size());
  std::vector<size_t> order(others.size());
  for (Eigen::Index place = 0; place < of_map.cols(); place++) {
    std::iota(order.begin(), order.end(), size_t{0});
    const auto best = order.begin() + static_cast<std::ptrdiff_t>(elected);
    std::partial_sort(order.begin(), best, order.end(), [&](size_t g, size_t h) {
      const float of_g = similarity(place, static_cast<Eigen::Index>(g)),
                  of_h = similarity(place, static_cast<Eigen::Index>(h));
      return of_g != of_h ? of_g > of_h : g < h;
    });
    for (auto i = order.begin(); i != best; ++i)
      votes[others[*i]] += 1.0 / static_cast<double>(of_map.cols());
  }
  return votes;
}

/** Returns all pairs, sorted by b, then by a. */
std::vector<CandidatePair> allPairs(size_t n) {
  std::vector<CandidatePair> pairs;
  for (size_t b = 0; b < n; b++)
    for (size_t a = 0; a < b; a++) pairs.push_back({a, b});
  return pairs;
}

/** Returns for each map the other maps that it may meet, most votes of both maps first. */
std::vector<std::vector<size_t>> partnersOf(const std::vector<std::vector<double>>& votes,
                                            const std::vector<std::vector<bool>>& may_meet) {
  std::vector<std::vector<size_t>> partners(votes.size());
  for (size_t k = 0; k < votes.size(); k++) {
    for (size_t other = 0; other < votes.size(); other++)
      if (may_meet[k][other]) partners[k].push_back(other);
    std::stable_sort(partners[k].begin(), partners[k].end(), [&](size_t g, size_t h) {
      return votes[k][g] + votes[g][k] > votes[k][h] + votes[h][k];
    });
  }
  return partners;
}

}  // namespace

std::vector<CandidatePair> candidatePairs(const std::vector<RobotMap>& maps, const Options& options,
                                          Executor& executor) {
  const size_t n = maps.size(), most = kMatchesPerMap * n;
  if (n * (n - 1) / 2 <= most) return allPairs(n);

  double scale = 0;
  for (const RobotMap& map : maps) scale = std::max(scale, map.map.scale());
  std::vector<Candidate> all(n);
  executor.run(n, [&](size_t k) {
    all[k] = {signatureOf(maps[k].map.features(), scale), boxOf(maps[k])};
  });
  const SearchParams search = scaledBy(options, scale).search;
  std::vector<std::vector<bool>> may_meet(n, std::vector<bool>(n));
  for (const auto& [a, b] : allPairs(n))
    may_meet[a][b] = may_meet[b][a] = mayMeet(all[a], all[b], priorOf(maps[b], maps[a]), search);
  std::vector<std::vector<double>> votes(n);
  executor.run(n, [&](size_t k) { votes[k] = votesOf(k, all, may_meet[k]); });

  // The best partner of each map comes first, then the second best partner, and so on.
  const auto partners = partnersOf(votes, may_meet);
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
