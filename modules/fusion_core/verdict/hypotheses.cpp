// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Ranks poses by the agreement of the maps. */
#include "fusion_core/verdict/hypotheses.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "fusion_base/parallel.h"
#include "fusion_core/features/thinning.h"

namespace mrpt::fusion {
namespace {

bool agreesBetter(const RankedPose& g, const RankedPose& h) { return g.agreement > h.agreement; }

/** Returns the poses, best first. Of poses at the same place it returns only the best. \a middle is
 * the mean of B's voxels, m, B's frame. */
std::vector<RankedPose> distinct(std::vector<RankedPose> all, const Eigen::Vector3d& middle,
                                 const PoseTolerance& tolerance) {
  std::stable_sort(all.begin(), all.end(), agreesBetter);
  std::vector<RankedPose> best;
  for (const RankedPose& h : all) {
    const bool is_new = std::none_of(best.begin(), best.end(), [&](const RankedPose& g) {
      return isSamePlace(g.T_a_b, h.T_a_b, middle, tolerance);
    });
    if (is_new) best.push_back(h);
  }
  return best;
}

}  // namespace

RegistrationParams roughly(RegistrationParams registration, const RankingParams& ranking) {
  registration.voxel_level.max_iterations =
      std::min(registration.voxel_level.max_iterations, ranking.max_iterations);
  registration.min_step_translation =
      std::max(registration.min_step_translation, ranking.min_step_translation);
  registration.min_step_rotation =
      std::max(registration.min_step_rotation, ranking.min_step_rotation);
  registration.solver.max_steps = 1;
  return registration;
}

double distanceBetween(const Eigen::Isometry3d& T, const Eigen::Isometry3d& U,
                       const Eigen::Vector3d& middle, const PoseTolerance& tolerance) {
  const Eigen::Isometry3d between = T.inverse() * U;
  return std::max((between * middle - middle).norm() / tolerance.translation,
                  Eigen::AngleAxisd(between.linear()).angle() / tolerance.rotation);
}

bool isSamePlace(const Eigen::Isometry3d& T, const Eigen::Isometry3d& U,
                 const Eigen::Vector3d& middle, const PoseTolerance& tolerance) {
  // distanceBetween() <= 1, without the angle: this is asked for many poses.
  const double most = tolerance.translation;
  if ((T * middle - U * middle).squaredNorm() > most * most) return false;
  const double sine = std::sin(std::min(tolerance.rotation, M_PI) / 2);
  return (T.linear() - U.linear()).squaredNorm() <= 8 * sine * sine;
}

PoseComparison::PoseComparison(const MapFeatures& a, const MapFeatures& b,
                               const VoxelAssociation& association, const ComparisonParams& params,
                               size_t voxels, SurfaceVoxels few_b)
    : a_(a),
      b_(b),
      association_(association),
      params_(params),
      rough_(roughly(params.registration, params.ranking)),
      few_b_(std::move(few_b)) {
  tbb::parallel_invoke(
      [&] { of_a_ = obstaclesOf(a, voxelsOf(a, params, voxels), params_.ranking.agreement); },
      [&] {
        of_b_ = obstaclesOf(b, few_b_, params_.ranking.agreement);
        H_m_ = occupancyUncertainty(a.matched.voxels.probability, few_b_.voxels.probability);
      });
}

PoseComparison::PoseComparison(const MapFeatures& a, const MapFeatures& b,
                               const VoxelAssociation& association, const ComparisonParams& params,
                               size_t voxels)
    : PoseComparison(a, b, association, params, voxels, voxelsOf(b, params, voxels)) {}

SurfaceVoxels PoseComparison::voxelsOf(const MapFeatures& map, const ComparisonParams& params,
                                       size_t voxels) {
  return fewOf(map.matched, params.spacing, voxels);
}

std::vector<RankedPose> PoseComparison::ranked(const std::vector<Eigen::Isometry3d>& starts) const {
  std::vector<RankedPose> reached(starts.size());
  forEachIndex(starts.size(), 1, [&](size_t i) { reached[i] = refined(starts[i]); });
  return distinct(std::move(reached), meanOf(few_b_.voxels.centre), params_.tolerance);
}

Matrix6d PoseComparison::covarianceAt(const Eigen::Isometry3d& T_a_b) const {
  VoxelLevel of_this_thread = level();
  return covarianceOf(a_, b_, of_this_thread, T_a_b, rough_);
}

double PoseComparison::agreementAt(const Eigen::Isometry3d& T_a_b) const {
  return agreement(a_, of_a_, b_, of_b_, T_a_b, params_.ranking.agreement, params_.border);
}

VoxelLevel PoseComparison::level() const {
  return VoxelLevel(a_.matched, few_b_, H_m_, association_, rough_);
}

RankedPose PoseComparison::refined(const Eigen::Isometry3d& start) const {
  MatchResult result;
  result.T_a_b = start;
  VoxelLevel of_this_thread = level();
  runLevel(of_this_thread, rough_.voxel_level, leastVoxelGate(a_, b_, rough_), rough_, result, {});
  return {result.T_a_b, agreementAt(result.T_a_b), result.covariance};
}

void compareRivals(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                   const ComparisonParams& params, std::vector<RankedPose>& hypotheses) {
  const RankingParams& ranking = params.ranking;
  std::vector<Eigen::Isometry3d> poses;
  for (const RankedPose& h : hypotheses)
    if (poses.size() < ranking.max_rivals &&
        h.agreement > ranking.min_rival_agreement * hypotheses.front().agreement)
      poses.push_back(h.T_a_b);
  if (poses.size() < 2) return;
  auto compared = PoseComparison(a, b, association, params, ranking.rival_voxels).ranked(poses);
  // The other poses keep their ratio to the best pose.
  const double scale = compared.front().agreement / hypotheses.front().agreement;
  for (size_t i = poses.size(); i < hypotheses.size(); i++) {
    hypotheses[i].agreement *= scale;
    compared.push_back(hypotheses[i]);
  }
  hypotheses = distinct(std::move(compared), meanOf(b.matched.voxels.centre), params.tolerance);
}

void compareWhatWasReached(const MapFeatures& a, const MapFeatures& b,
                           const VoxelAssociation& association, const ComparisonParams& params,
                           MatchResult& result) {
  const Eigen::Vector3d middle = meanOf(b.matched.voxels.centre);
  if (distanceBetween(result.hypotheses.front().T_a_b, result.T_a_b, middle, params.tolerance) <=
      params.ranking.moved_share)
    return;
  std::vector<RankedPose> compared{{result.T_a_b, 0, result.covariance}};
  for (const RankedPose& h : result.hypotheses)
    if (!isSamePlace(h.T_a_b, result.T_a_b, middle, params.tolerance)) compared.push_back(h);
  const PoseComparison comparison(a, b, association, params, params.ranking.rival_voxels);
  forEachIndex(compared.size(), 1, [&](size_t i) {
    compared[i].agreement = comparison.agreementAt(compared[i].T_a_b);
  });
  std::stable_sort(compared.begin() + 1, compared.end(), agreesBetter);
  result.hypotheses = std::move(compared);
}

void makeFirst(size_t i, std::vector<RankedPose>& hypotheses) {
  const auto first = hypotheses.begin();
  const auto chosen = first + static_cast<std::ptrdiff_t>(i);
  std::rotate(first, chosen, chosen + 1);
  std::stable_sort(first + 1, hypotheses.end(), agreesBetter);
}

void addRival(const MapFeatures& b, RankedPose rival, double ratio, const PoseTolerance& tolerance,
              MatchResult& result) {
  auto& hypotheses = result.hypotheses;
  rival.agreement = ratio * hypotheses.front().agreement;
  const Eigen::Vector3d middle = meanOf(b.matched.voxels.centre);
  const auto holds = [&](const RankedPose& h) {
    return isSamePlace(h.T_a_b, rival.T_a_b, middle, tolerance);
  };
  const auto same = std::find_if(hypotheses.begin() + 1, hypotheses.end(), holds);
  if (same != hypotheses.end()) {
    if (same->agreement >= rival.agreement) return;
    hypotheses.erase(same);
  }
  hypotheses.insert(std::upper_bound(hypotheses.begin() + 1, hypotheses.end(), rival, agreesBetter),
                    rival);
}

std::optional<BetterPose> betterPoseElsewhere(const MapFeatures& a, const MapFeatures& b,
                                              const Eigen::Isometry3d& T_a_b,
                                              const Eigen::Isometry3d& elsewhere, double as_good,
                                              const ComparisonParams& params) {
  const VoxelAssociation association = associationOf(a, b, params.registration);
  const auto ranked = PoseComparison(a, b, association, params, params.ranking.rival_voxels)
                          .ranked({T_a_b, elsewhere});
  if (ranked.size() < 2 || ranked[1].agreement > as_good * ranked[0].agreement ||
      isSamePlace(ranked[0].T_a_b, T_a_b, meanOf(b.matched.voxels.centre), params.tolerance))
    return {};
  return BetterPose{ranked[0], ranked[1].agreement};
}

void insertBetter(const BetterPose& better, MatchResult& result) {
  if (result.hypotheses.empty())
    result.hypotheses.push_back({result.T_a_b, better.of_match, result.covariance});
  RankedPose rival = better.pose;
  if (better.of_match > 0) rival.agreement *= result.hypotheses.front().agreement / better.of_match;
  result.hypotheses.insert(result.hypotheses.begin() + 1, rival);
}

}  // namespace mrpt::fusion
