// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Matches the pairs of a team. */
#include "fusion_team/pairs/pair_matches.h"

#include <algorithm>
#include <limits>
#include <mutex>
#include <numeric>

#include "fusion_base/error_text.h"
#include "fusion_core/features/features.h"
#include "fusion_core/pair/match.h"
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

std::vector<Eigen::Isometry3d> hypothesesOf(const PairMatch& match) {
  constexpr size_t kMost = 12;
  const MatchResult& result = match.alignment.match;
  std::vector<Eigen::Isometry3d> poses;
  for (const RankedPose& h : result.hypotheses)
    if (poses.size() < kMost) poses.push_back(h.T_a_b);
  // The first hypothesis is the match before the registration with all voxels.
  if (!poses.empty()) poses.front() = result.T_a_b;
  return poses;
}

std::vector<PairMatch> matchPairs(const std::vector<RobotMap>& maps,
                                  const std::vector<CandidatePair>& pairs, const Options& options,
                                  Executor& executor, const OnMember& on_member,
                                  PairMemory& memory) {
  std::vector<PairMatch> matches;
  for (const auto& [a, b] : pairs) matches.push_back({a, b, {}});
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

std::vector<PairMatch> matchPairs(const std::vector<RobotMap>& maps, const Options& options,
                                  Executor& executor, const OnMember& on_member,
                                  PairMemory& memory) {
  return matchPairs(maps, candidatePairs(maps, options, executor, memory), options, executor,
                    on_member, memory);
}

EvidenceOfMaps::EvidenceOfMaps(const std::vector<RobotMap>& maps, const Options& options,
                               PairMemory& memory)
    : maps_(maps),
      pairs_(maps.size()),
      sure_(maps.size()),
      conflict_tolerance_(maps.size(), kLeastTolerance) {
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
  min_overlap_ = options.evaluation.min_overlap;
  max_conflict_ = options.evaluation.max_free_conflict;
  tolerance_ = options.evaluation.tolerance;
  tolerance_.translation *= scale;
}

double EvidenceOfMaps::fit(const PairEvidence& e) const {
  return e.confirmed() - (e.displaced() + e.contradicted()) / kMostTolerance;
}

double EvidenceOfMaps::overlapOf(size_t a, size_t b, const PairEvidence& e) const {
  const auto area = [&](const ComparedObstacles& of_map, size_t map) {
    return area_of_obstacle_[map] * countOf(of_map.confirmed);
  };
  return (area(e.of_a, a) + area(e.of_b, b)) / (area_[a] + area_[b]);
}

double EvidenceOfMaps::rivalOf(const PairMatch& match, const Eigen::Isometry3d& T_a_b) const {
  const PairEvidence& of_pose = near(match.a, match.b, T_a_b);
  if (overlapOf(match.a, match.b, of_pose) < min_overlap_ || fit(of_pose) <= 0)
    return std::numeric_limits<double>::infinity();
  double rival = 0;
  for (const Eigen::Isometry3d& T : hypothesesOf(match)) {
    const PairEvidence& e = near(match.a, match.b, T);
    if (!isSame(match.b, e.T_a_b, of_pose.T_a_b)) rival = std::max(rival, fit(e));
  }
  return rival / fit(of_pose);
}

bool EvidenceOfMaps::holds(const PairMatch& match) const {
  return match.alignment.evaluation.accepted && rivalOf(match, match.alignment.match.T_a_b) <= 1;
}

bool EvidenceOfMaps::isClear(const PairMatch& match, const Eigen::Isometry3d& T_a_b) const {
  const PairEvidence& e = near(match.a, match.b, T_a_b);
  const double conflicts = e.displaced() + e.contradicted();
  return conflicts <= max_conflict_ * (e.confirmed() + conflicts) &&
         rivalOf(match, T_a_b) <= kMostRivalOfClear;
}

std::optional<Eigen::Isometry3d> EvidenceOfMaps::clearPoseOf(const PairMatch& match) const {
  for (const Eigen::Isometry3d& T : hypothesesOf(match))
    if (isClear(match, T)) return T;
  return std::nullopt;
}

void EvidenceOfMaps::adaptTolerance(const std::vector<PairMatch>& matches) {
  constexpr double kFactor = 5;  // a team has more conflicts than a pair: any map may show it
  struct Shares {
    std::vector<double> displaced, contradicted;
  };
  std::vector<size_t> place(size());  // maps that clear poses connect have the same
  std::iota(place.begin(), place.end(), 0);
  std::vector<std::pair<size_t, const PairEvidence*>> clear;
  for (const PairMatch& m : matches) {
    const auto T = clearPoseOf(m);
    if (!T) continue;
    clear.emplace_back(m.a, &near(m.a, m.b, *T));
    // By value: the elements themselves change.
    std::replace(place.begin(), place.end(), size_t(place[m.b]), size_t(place[m.a]));
  }
  std::vector<Shares> of_place(size());
  for (const auto& [map, e] : clear) {
    const double known = e->confirmed() + e->displaced() + e->contradicted();
    of_place[place[map]].displaced.push_back(e->displaced() / known);
    of_place[place[map]].contradicted.push_back(e->contradicted() / known);
  }
  for (size_t k = 0; k < size(); k++) {
    const Shares& shares = of_place[place[k]];
    conflict_tolerance_[k] = {std::clamp(kFactor * exceededBy(0.5, shares.displaced),
                                         kLeastTolerance.displaced, kMostTolerance),
                              std::clamp(kFactor * exceededBy(0.1, shares.contradicted),
                                         kLeastTolerance.contradicted, kMostTolerance)};
  }
}

void EvidenceOfMaps::setSureMatches(const std::vector<PairMatch>& matches,
                                    double least_probability) {
  for (const PairMatch& m : matches) {
    const Evaluation& e = m.alignment.evaluation;
    const Eigen::Isometry3d& T = m.alignment.match.T_a_b;
    const bool is_match = holds(m) && (e.probability >= least_probability || isClear(m, T));
    const auto pose = is_match ? std::optional(T) : clearPoseOf(m);
    sure_[m.a][m.b - m.a - 1] = pose ? std::optional(SurePose{*pose, is_match}) : std::nullopt;
  }
  for (const auto& [pair, poses] : posesByOthers()) {
    const auto [a, b] = pair;
    const auto pose = sureMatch(a, b) ? std::nullopt : mostAgreed(b, poses);
    if (pose) sure_[a][b - a - 1] = SurePose{*pose, false};
  }
}

std::map<std::pair<size_t, size_t>, std::vector<Eigen::Isometry3d>> EvidenceOfMaps::posesByOthers()
    const {
  std::map<std::pair<size_t, size_t>, std::vector<Eigen::Isometry3d>> poses;
  for (size_t k = 0; k < size(); k++) {
    std::vector<std::pair<size_t, Eigen::Isometry3d>> of_k;  // sure matches of map k: T_k_map
    for (size_t i = 0; i < size(); i++) {
      if (i == k) continue;
      const auto T = sureMatch(std::min(i, k), std::max(i, k));
      if (T) of_k.emplace_back(i, k < i ? *T : T->inverse());
    }
    for (const auto& [a, T_k_a] : of_k)
      for (const auto& [b, T_k_b] : of_k)
        if (a < b) poses[{a, b}].push_back(T_k_a.inverse() * T_k_b);
  }
  return poses;
}

std::optional<Eigen::Isometry3d> EvidenceOfMaps::mostAgreed(
    size_t b, const std::vector<Eigen::Isometry3d>& poses) const {
  const auto votesFor = [&](const Eigen::Isometry3d& T) {
    return std::count_if(poses.begin(), poses.end(),
                         [&](const Eigen::Isometry3d& U) { return isSame(b, T, U); });
  };
  std::vector<std::ptrdiff_t> votes(poses.size());
  std::transform(poses.begin(), poses.end(), votes.begin(), votesFor);
  const auto most = std::max_element(votes.begin(), votes.end());
  if (most == votes.end() || *most < 2) return std::nullopt;
  const Eigen::Isometry3d& best = poses[static_cast<size_t>(most - votes.begin())];
  for (size_t i = 0; i < poses.size(); i++)
    if (votes[i] == *most && !isSame(b, best, poses[i])) return std::nullopt;
  return best;
}

bool EvidenceOfMaps::isSure(size_t a, size_t b, const Eigen::Isometry3d& T_a_b) const {
  const auto& sure = sure_[a][b - a - 1];
  return sure && isSame(b, T_a_b, sure->T_a_b);
}

std::optional<Eigen::Isometry3d> EvidenceOfMaps::sureMatch(size_t a, size_t b) const {
  const auto& sure = sure_[a][b - a - 1];
  return sure && sure->is_match ? std::optional(sure->T_a_b) : std::nullopt;
}

const PairEvidence& EvidenceOfMaps::near(size_t a, size_t b, const Eigen::Isometry3d& T_a_b) const {
  return pairs_[a][b - a - 1]->near(T_a_b);
}

Matrix6d EvidenceOfMaps::covariance(size_t a, size_t b, const Eigen::Isometry3d& registered) const {
  return pairs_[a][b - a - 1]->covarianceAt(registered);
}

bool EvidenceOfMaps::isSame(size_t b, const Eigen::Isometry3d& T,
                            const Eigen::Isometry3d& U) const {
  return isSamePlace(T, U, middle_[b], tolerance_);
}

bool EvidenceOfMaps::isNearlySame(size_t b, const Eigen::Isometry3d& T,
                                  const Eigen::Isometry3d& U) const {
  return isSamePlace(
      T, U, middle_[b],
      {kSharedEvidence * tolerance_.translation, kSharedEvidence * tolerance_.rotation});
}

}  // namespace mrpt::fusion
