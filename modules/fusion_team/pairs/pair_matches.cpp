// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Matches the pairs of a team. */
#include "fusion_team/pairs/pair_matches.h"

#include <algorithm>
#include <mutex>

#include "fusion_base/error_text.h"
#include "fusion_core/features/features.h"
#include "fusion_core/pair/match.h"
#include "fusion_team/pairs/candidates.h"
#include "fusion_team/pairs/pair_prior.h"

namespace mrpt::fusion {
namespace {

/** Returns the value that a share of the values exceeds; 0 without values. */
double exceededBy(double share, std::vector<double> values) {
  if (values.empty()) return 0;
  const double rank = (1 - share) * static_cast<double>(values.size());
  const auto value = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), value, values.end());
  return *value;
}

}  // namespace

std::vector<PairMatch> matchPairs(const std::vector<RobotMap>& maps, const Options& options,
                                  Executor& executor, const OnMember& on_member,
                                  PairMemory& memory) {
  std::vector<PairMatch> matches;
  for (const auto& [a, b] : candidatePairs(maps, options, executor)) matches.push_back({a, b, {}});
  std::mutex mutex;
  executor.run(matches.size(), [&](size_t i) {
    PairMatch& m = matches[i];
    withPath(maps[m.b].robot, [&] {
      const PreparedMap &a = maps[m.a].map, &b = maps[m.b].map;
      const Prior prior = priorOf(maps[m.b], maps[m.a]);
      m.alignment = memory.match(a, b, prior, [&] {
        if (on_member) {
          const std::lock_guard<std::mutex> lock(mutex);
          on_member(maps[m.b].robot, m.a + 1);
        }
        return align(a, b, prior, options);
      });
    });
  });
  return matches;
}

EvidenceOfMaps::EvidenceOfMaps(const std::vector<RobotMap>& maps, const Options& options,
                               PairMemory& memory)
    : maps_(maps), pairs_(maps.size()), sure_(maps.size()) {
  double scale = 0;
  for (size_t a = 0; a < maps.size(); a++) {
    const MapFeatures& map = maps[a].map.features();
    const auto few =
        PoseComparison::voxelsOf(map, comparisonOf(options), options.ranking.many_voxels);
    const double side = map.voxels.resolution;
    area_.push_back(side * side * static_cast<double>(map.voxels.size()));
    area_of_obstacle_.push_back(area_.back() /
                                static_cast<double>(std::max<size_t>(few.voxels.size(), 1)));
    box_.push_back(boxOf(map));
    middle_.push_back(meanOf(map.matched.voxels.centre));
    scale = std::max(scale, map.scale);
    for (size_t b = a + 1; b < maps.size(); b++)
      pairs_[a].push_back(memory.evidence(maps[a].map, maps[b].map, options));
    sure_[a].resize(pairs_[a].size());
  }
  tolerance_ = options.evaluation.tolerance;
  tolerance_.translation *= scale;
}

void EvidenceOfMaps::adaptTolerance(const std::vector<PairMatch>& matches) {
  constexpr double kFactor = 5;   // a team has more conflicts than a pair: any map may show it
  constexpr double kClear = 0.5;  // a wrong match that was accepted has a strong rival
  std::vector<double> displaced, contradicted;  // shares
  for (const PairMatch& m : matches) {
    const Evaluation& verdict = m.alignment.evaluation;
    if (!verdict.accepted || verdict.rival_weight > kClear) continue;
    const PairEvidence& e = near(m.a, m.b, m.alignment.match.T_a_b);
    const double known = e.confirmed() + e.displaced() + e.contradicted();
    if (known == 0) continue;
    displaced.push_back(e.displaced() / known);
    contradicted.push_back(e.contradicted() / known);
  }
  const double most = conflict_tolerance_.explained;
  conflict_tolerance_ = {
      std::clamp(kFactor * exceededBy(0.5, displaced), kLeastTolerance.displaced, most),
      std::clamp(kFactor * exceededBy(0.1, contradicted), kLeastTolerance.contradicted, most)};
}

void EvidenceOfMaps::setSureMatches(const std::vector<PairMatch>& matches,
                                    double least_probability) {
  for (const PairMatch& m : matches) {
    const Evaluation& verdict = m.alignment.evaluation;
    if (verdict.accepted && verdict.probability >= least_probability)
      sure_[m.a][m.b - m.a - 1] = m.alignment.match.T_a_b;
  }
}

bool EvidenceOfMaps::isSure(size_t a, size_t b, const Eigen::Isometry3d& T_a_b) const {
  const auto& T = sure_[a][b - a - 1];
  return T && isSame(b, T_a_b, *T);
}

const PairEvidence& EvidenceOfMaps::near(size_t a, size_t b, const Eigen::Isometry3d& T_a_b) const {
  return pairs_[a][b - a - 1]->near(T_a_b);
}

bool EvidenceOfMaps::isSame(size_t b, const Eigen::Isometry3d& T,
                            const Eigen::Isometry3d& U) const {
  return isSamePlace(T, U, middle_[b], tolerance_);
}

}  // namespace mrpt::fusion
