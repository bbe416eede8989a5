// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Computes the evidence for and against a match, and the verdict. */
#include "fusion_core/verdict/evaluation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "fusion_base/parallel.h"
#include "fusion_base/whole_number.h"
#include "fusion_core/features/thinning.h"
#include "fusion_core/map/occupancy_query.h"
#include "fusion_core/registration/pose_covariance.h"
#include "fusion_core/verdict/agreement.h"
#include "fusion_core/verdict/reasons.h"

namespace mrpt::fusion {
namespace {

/** Returns the number of voxels of \a size that hold a map's occupied voxels. Cost: O(n log n). */
size_t countInVoxelsOf(double size, const OccupiedVoxels& voxels) {
  std::vector<std::array<int, 3>> taken(voxels.size());
  std::transform(voxels.centre.begin(), voxels.centre.end(), taken.begin(), [&](const auto& p) {
    const auto at = [&](unsigned axis) { return toWhole(std::floor(p[axis] / size)); };
    return std::array<int, 3>{at(0), at(1), at(2)};
  });
  std::sort(taken.begin(), taken.end());
  return static_cast<size_t>(std::unique(taken.begin(), taken.end()) - taken.begin());
}

/** Returns countInVoxelsOf() over the number of the map's voxels. */
double coarseningTo(double size, const OccupiedVoxels& voxels) {
  if (size <= voxels.resolution || voxels.size() == 0) return 1;
  return static_cast<double>(countInVoxelsOf(size, voxels)) / static_cast<double>(voxels.size());
}

/** Returns the share of the occupied voxels that touch no other occupied voxel, of each
 * \a stride-th. */
double shareOfLone(const MapVoxels& map, size_t stride) {
  const VoxelBlocks::Ball touching(std::sqrt(3.0), 0);
  const size_t n = (map.voxels.size() + stride - 1) / stride;
  size_t lone = 0;
  for (size_t i = 0; i < n; i++) {
    const auto& key = map.voxels.key[stride * i];
    lone += map.occupied.anyAround({key[0], key[1], key[2]}, touching) ? 0 : 1;
  }
  return n > 0 ? static_cast<double>(lone) / static_cast<double>(n) : 0;
}

/** Returns the factor of the weight of a rival for the obstacles that it confirms, see
 * EvaluationParams::min_rival_support. */
double rivalShare(const Evaluation& e, const EvaluationParams& params) {
  const auto share = [&](double support) {
    return support < params.min_rival_support ? support / params.min_rival_support : 1;
  };
  const double facing = share(e.rival_same_side);
  return share(e.rival_support) * (facing + (1 - facing) * params.other_side_rival);
}

/** Returns Evaluation::rival_same_side. */
double sameSideSupport(const Eigen::Isometry3d& rival, const MapFeatures& a, const MapFeatures& b,
                       const Eigen::Isometry3d& T_a_b, const EvaluationParams& params) {
  const auto obstacles = [&](const MapFeatures& map) {
    return obstaclesOf(map, fewOf(map.matched, 0, params.voxels));
  };
  const Obstacles of_a = obstacles(a), of_b = obstacles(b);
  const size_t of_match = confirmedFromSameSide(a, of_a, b, of_b, T_a_b);
  if (of_match == 0) return 1;
  const size_t of_rival = confirmedFromSameSide(a, of_a, b, of_b, rival);
  return std::min(1.0, static_cast<double>(of_rival) / static_cast<double>(of_match));
}

Rival rivalOf(const MapFeatures& a, const MapFeatures& b, const MatchResult& match,
              const EvaluationParams& params) {
  if (match.runnerUp() <= 0) return {};
  const Eigen::Isometry3d& T = match.hypotheses[1].T_a_b;
  return {match.runnerUp(), T, [&, T] { return sameSideSupport(T, a, b, match.T_a_b, params); }};
}

}  // namespace

double mahalanobisDistance(double squared_distance, double p_a, double p_b) {
  return std::sqrt(squared_distance / (1 / p_a + 1 / p_b));
}

double overlapOf(double matches, double voxels_a, double voxels_b) {
  if (voxels_a == 0 || voxels_b == 0) return 0;
  return 0.5 * (std::min(matches / voxels_b, 1.0) + std::min(matches / voxels_a, 1.0));
}

double acceptanceThreshold(double overlap, const EvaluationParams& params) {
  return std::clamp(params.threshold_without_overlap - overlap * params.threshold_per_overlap,
                    params.min_threshold, params.max_threshold);
}

double probabilityOfStaying(const PoseDeviation& deviation, const PoseTolerance& tolerance) {
  const auto within = [](double limit, double sigma) {
    return sigma > 0 ? std::erf(limit / (std::sqrt(2.0) * sigma)) : 1;
  };
  return within(tolerance.translation, deviation.translation) *
         within(tolerance.rotation, deviation.rotation);
}

FreeSpaceCheck checkFreeSpace(const MapVoxels& a, const OccupiedVoxels& b,
                              const Eigen::Isometry3d& T_a_b, size_t stride,
                              const BorderParams& border) {
  std::vector<ObstacleCheck> checks((b.size() + stride - 1) / stride);
  std::vector<double> discounts(checks.size());
  forEachIndex(checks.size(), kGrain, [&](size_t i) {
    const Eigen::Vector3d place = T_a_b * b.centre[stride * i].cast<double>();
    checks[i] = checkObstacle(a, place);
    if (checks[i] == ObstacleCheck::Conflicting)
      discounts[i] = 1 - conflictWeight(a, place, border);
  });
  const auto count = [&](ObstacleCheck c) {
    return static_cast<size_t>(std::count(checks.begin(), checks.end(), c));
  };
  FreeSpaceCheck check;
  check.agreeing = count(ObstacleCheck::Confirmed);
  check.conflicting = count(ObstacleCheck::Conflicting);
  check.missed = count(ObstacleCheck::Missed);
  check.discount = std::accumulate(discounts.begin(), discounts.end(), 0.0);
  if (!a.has_free_space) check.agreeing_without_free = check.agreeing;
  return check;
}

Evaluation evaluateMatch(const MapVoxels& a, const MapVoxels& b, const Pairs& pairs,
                         const Eigen::Isometry3d& T_a_b, const EvaluationParams& params,
                         const Rival& rival, const PoseDeviation& deviation,
                         const SizeRatio& size_ratio) {
  Evaluation e;
  const size_t stride_a = strideFor(a.voxels.size(), params.voxels),
               stride_b = strideFor(b.voxels.size(), params.voxels);
  e.sampled = (b.voxels.size() + stride_b - 1) / stride_b;
  e.pairs = pairs.size();
  // Both maps are counted in voxels of the larger size: smaller voxels must not increase the weight
  // of a wall.
  const double size = std::max(a.voxels.resolution, b.voxels.resolution);
  const double counted_a = coarseningTo(size, a.voxels),
               counted_b = coarseningTo(size, b.voxels) * static_cast<double>(stride_b);
  e.overlap = overlapOf(counted_b * static_cast<double>(pairs.size()),
                        counted_a * static_cast<double>(a.voxels.size()),
                        counted_b * static_cast<double>(e.sampled));
  e.threshold = acceptanceThreshold(e.overlap, params);
  double sum = 0;
  for (const Pair& p : pairs) {
    const double d = mahalanobisDistance(p.squared_distance, a.voxels.probability[p.a],
                                         b.voxels.probability[p.b]);
    sum += d;
    e.log_likelihood -= d * d;
    if (d < params.inlier_mahalanobis) e.inliers++;
  }
  if (!pairs.empty()) {
    e.mean_mahalanobis = sum / static_cast<double>(pairs.size());
    e.inlier_ratio = static_cast<double>(e.inliers) / static_cast<double>(pairs.size());
  }
  // Both maps use the same stride, so both have the same weight.
  const size_t stride = std::max(stride_a, stride_b);
  const auto bothWays = [&](const Eigen::Isometry3d& T) {
    return checkFreeSpace(a, b.voxels, T, stride, params.border) +
           checkFreeSpace(b, a.voxels, T.inverse(), stride, params.border);
  };
  e.free_space = bothWays(T_a_b);
  const double conflict = e.free_space.conflictRatio();
  const double stays = probabilityOfStaying(deviation, params.tolerance);
  const auto probabilityWith = [&](double runner_up) {
    return stays * params.model.probability(e.overlap, conflict, runner_up, e.inlier_ratio);
  };
  e.runner_up = rival.ratio;
  // A match that is sure in spite of its rival needs no second look at the rival.
  const bool is_sure = rival.ratio <= params.max_runner_up &&
                       probabilityWith(rival.ratio) >= params.sure_probability;
  if (rival.T_a_b && !is_sure && e.free_space.agreeing > 0)
    e.rival_support = std::min(1.0, static_cast<double>(bothWays(*rival.T_a_b).agreeing) /
                                        static_cast<double>(e.free_space.agreeing));
  if (rival.same_side && !is_sure) e.rival_same_side = rival.same_side();
  e.rival_weight = rival.ratio * (rival.ratio > 1 ? 1 : rivalShare(e, params));
  e.without_free_space = 0.5 * ((a.has_free_space ? 0 : 1) + (b.has_free_space ? 0 : 1));

  e.size_ratio = size_ratio;
  e.deviation = deviation;
  e.probability = probabilityWith(e.rival_weight);
  decide({a.voxels.resolution, b.voxels.resolution, shareOfLone(a, stride_a),
          shareOfLone(b, stride_b), rival.T_a_b, stays, probabilityWith(0)},
         params, e);
  return e;
}

Evaluation judge(const MapFeatures& a, const MapFeatures& b, const MatchResult& match,
                 const EvaluationParams& params) {
  if (isEmpty(a, b)) return evaluateMatch(a, b, {}, match.T_a_b, params);
  Evaluation e =
      evaluateMatch(a, b, match.pairs, match.T_a_b, params, rivalOf(a, b, match, params),
                    deviationAt(match.covariance, match.T_a_b * meanOf(b.matched.voxels.centre)),
                    match.size_ratio);
  if (!match.hypotheses.empty()) e.other_poses = OtherPoses::Compared;
  return e;
}

}  // namespace mrpt::fusion
