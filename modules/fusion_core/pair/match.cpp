// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Runs the stages of a match: search, ranking, registration. */
#include "fusion_core/pair/match.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "fusion_base/parallel.h"
#include "fusion_core/registration/size_ratio.h"
#include "fusion_core/registration/two_level.h"
#include "fusion_core/search/all_rotations.h"
#include "fusion_core/search/levelling.h"
#include "fusion_core/search/pose_search.h"

namespace mrpt::fusion {
namespace {

/** Runs the search of the options. \a few_b holds some of B's voxels, about one in each cell. */
std::vector<Hypothesis> searchedStarts(const MapFeatures& a, const MapFeatures& b,
                                       const SurfaceVoxels& few_b, const Eigen::Isometry3d& T_a_b,
                                       const SearchParams& search) {
  if (!search.isEverywhere()) return searchAround(a, a.matched.surfaces, few_b, T_a_b, search);
  return search.rotations == SearchRotations::All
             ? searchAllRotations(a, a.matched.surfaces, few_b, search)
             : searchLevelled(a, a.matched, b.matched, few_b, T_a_b, search);
}

/** Returns the best starts by few voxels. A comparison of all starts by many voxels would dominate
 * the cost of the match. */
std::vector<Eigen::Isometry3d> bestByFew(const PoseComparison& by_few,
                                         const std::vector<Eigen::Isometry3d>& starts,
                                         size_t most) {
  const auto best = by_few.ranked(starts);
  std::vector<Eigen::Isometry3d> poses;
  for (size_t i = 0; i < std::min(best.size(), most); i++) poses.push_back(best[i].T_a_b);
  return poses;
}

/** Returns the gate of a registration that starts near the pose, m. */
double gateNearPose(const MapFeatures& a, const MapFeatures& b, const RegistrationParams& params) {
  return std::min(params.voxel_level.gate,
                  std::max(params.voxel_level.final_gate, leastVoxelGate(a, b, params)));
}

/** Returns the number of the best hypothesis that agrees better than what the registration reached,
 * and from which no registration has begun; the number of all hypotheses if there is none. */
size_t nextToRegister(const std::vector<RankedPose>& hypotheses,
                      const std::vector<Eigen::Isometry3d>& begun, const Eigen::Vector3d& middle,
                      const PoseTolerance& tolerance) {
  const auto is_next = [&](const RankedPose& h) {
    return h.agreement > hypotheses.front().agreement &&
           std::none_of(begun.begin(), begun.end(), [&](const Eigen::Isometry3d& T) {
             return isSamePlace(h.T_a_b, T, middle, tolerance);
           });
  };
  return static_cast<size_t>(std::find_if(hypotheses.begin(), hypotheses.end(), is_next) -
                             hypotheses.begin());
}

}  // namespace

void registerRivals(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                    const Eigen::Isometry3d& began, const Options& options, MatchResult& result,
                    const OnIteration& on_iteration) {
  const RegistrationParams& registration = options.registration;
  const Eigen::Vector3d middle = meanOf(b.matched.voxels.centre);
  std::vector<Eigen::Isometry3d> begun{began};
  while (begun.size() < options.ranking.max_rivals) {
    const size_t rival =
        nextToRegister(result.hypotheses, begun, middle, options.evaluation.tolerance);
    if (rival == result.hypotheses.size()) return;
    MatchResult other;
    other.T_a_b = result.hypotheses[rival].T_a_b;
    other.iterations = result.iterations;
    other.hypotheses = result.hypotheses;
    makeFirst(rival, other.hypotheses);
    begun.push_back(other.T_a_b);
    matchVoxels(a, b, association, gateNearPose(a, b, registration), registration,
                options.evaluation.voxels, other, on_iteration);
    compareWhatWasReached(a, b, association, comparisonOf(options), other);
    if (other.hypotheses.front().agreement > result.hypotheses.front().agreement)
      result = std::move(other);
    else
      result.iterations = std::move(other.iterations);
  }
}

ComparisonParams comparisonOf(const Options& options) {
  const EvaluationParams& verdict = options.evaluation;
  return {options.registration, options.ranking, verdict.tolerance, verdict.border,
          options.search.cell};
}

MatchResult matchMaps(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                      const Options& options, const OnIteration& on_iteration) {
  const RegistrationParams& registration = options.registration;
  const RankingParams& ranking = options.ranking;
  if (isEmpty(a, b) || options.search.translation <= 0)
    return matchTwoLevel(a, b, T_a_b, registration, options.evaluation.voxels, on_iteration);

  // 1. Starts: the guess after the edge level, and a search around the guess. The comparison is
  // prepared at the same time.
  MatchResult result;
  result.T_a_b = T_a_b;
  const ComparisonParams comparison = comparisonOf(options);
  const SurfaceVoxels few_b = PoseComparison::voxelsOf(b, comparison, ranking.many_voxels);
  std::vector<Eigen::Isometry3d> starts;
  std::vector<Hypothesis> found;
  std::optional<VoxelAssociation> of_voxels;
  std::optional<PoseComparison> comparing;
  tbb::parallel_invoke(
      [&] {
        if (options.search.isEverywhere()) return;
        matchEdges(a, b, roughly(registration, ranking), result, on_iteration);
        starts.push_back(result.T_a_b);
      },
      [&] { found = searchedStarts(a, b, few_b, T_a_b, options.search); },
      [&] {
        of_voxels.emplace(associationOf(a, b, registration));
        comparing.emplace(a, b, *of_voxels, comparison, ranking.many_voxels, few_b);
      });
  const VoxelAssociation& association = *of_voxels;
  const PoseComparison& by_many = *comparing;
  for (const Hypothesis& h : found) starts.push_back(h.T_a_b);
  if (starts.empty()) starts.push_back(T_a_b);

  // 2. Ranking: all starts by few voxels, the best starts by many voxels, the rivals of the best
  // pose by more voxels.
  if (starts.size() > ranking.max_starts)
    starts = bestByFew(PoseComparison(a, b, association, comparison, ranking.few_voxels), starts,
                       ranking.max_starts);
  result.hypotheses = by_many.ranked(starts);
  compareRivals(a, b, association, comparison, result.hypotheses);

  // 3. Registration of the best pose with all voxels. The covariances of its rivals are computed at
  // the same time: each of the two tasks has too little work for many threads.
  const Eigen::Isometry3d best = result.hypotheses.front().T_a_b;
  result.T_a_b = best;
  tbb::parallel_invoke(
      [&] {
        forEachIndex(result.hypotheses.size(), 1, [&](size_t i) {
          RankedPose& h = result.hypotheses[i];
          if (h.agreement > ranking.min_rival_agreement * result.hypotheses.front().agreement)
            h.covariance = by_many.covarianceAt(h.T_a_b);
        });
      },
      [&] {
        matchVoxels(a, b, association, gateNearPose(a, b, registration), registration,
                    options.evaluation.voxels, result, on_iteration);
      });
  compareWhatWasReached(a, b, association, comparison, result);
  registerRivals(a, b, association, best, options, result, on_iteration);
  return result;
}

double coarseAgreement(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                       Options options) {
  constexpr double kWider = 2;          // most width of a cell over that of a match
  constexpr double kCells = 32;         // least number of cells along the diagonal of a map
  constexpr size_t kVoxels = 300;       // of each map
  constexpr unsigned kHypotheses = 64;  // of the search
  constexpr size_t kRefined = 16;       // of these
  if (isEmpty(a, b)) return 0;
  const double diagonal = std::min(boxOf(a).diagonal().norm(), boxOf(b).diagonal().norm());
  double& cell = options.search.cell;
  cell = std::clamp(diagonal / kCells, cell, kWider * cell);
  options.search.hypotheses = std::min(options.search.hypotheses, kHypotheses);
  const ComparisonParams comparison = comparisonOf(options);
  const SurfaceVoxels few_b = PoseComparison::voxelsOf(b, comparison, kVoxels);
  std::vector<Hypothesis> found;
  if (options.search.translation > 0) found = searchedStarts(a, b, few_b, T_a_b, options.search);
  if (found.empty()) found.push_back({T_a_b, 0});

  const VoxelAssociation association = associationOf(a, b, options.registration);
  const PoseComparison by_few(a, b, association, comparison, kVoxels, few_b);
  for (Hypothesis& h : found) h.score = by_few.agreementAt(h.T_a_b);
  std::stable_sort(found.begin(), found.end(),
                   [](const Hypothesis& g, const Hypothesis& h) { return g.score > h.score; });
  double best = 0;
  for (size_t i = 0; i < std::min(kRefined, found.size()); i++)
    best = std::max(best, by_few.refined(found[i].T_a_b).agreement);
  return best;
}

MatchResult matchFrom(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                      const Options& options) {
  const RegistrationParams& registration = options.registration;
  const VoxelAssociation association = associationOf(a, b, registration);
  MatchResult result;
  result.T_a_b = T_a_b;
  matchVoxels(a, b, association, gateNearPose(a, b, registration), registration,
              options.evaluation.voxels, result, {});
  const bool stays = isSamePlace(result.T_a_b, T_a_b, meanOf(b.matched.voxels.centre),
                                 options.evaluation.tolerance);
  return stays ? result : matchAt(a, b, T_a_b, options);
}

MatchResult matchAt(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                    const Options& options) {
  MatchResult result;
  result.T_a_b = T_a_b;
  if (isEmpty(a, b)) return result;
  result.pairs = pairVoxels(a, b, T_a_b, options.registration, options.evaluation.voxels);
  const VoxelAssociation association = associationOf(a, b, options.registration);
  VoxelLevel level = voxelLevel(a, b, association, options.registration);
  result.covariance = covarianceOf(a, b, level, T_a_b, options.registration);
  const Pairs pairs = firstPairs(level, T_a_b, leastVoxelGate(a, b, options.registration),
                                 options.registration.first_pairs);
  result.size_ratio = sizeRatioAt(a.matched, b.matched, pairs, T_a_b, association, level.H_m(),
                                  options.registration);
  return result;
}

}  // namespace mrpt::fusion
