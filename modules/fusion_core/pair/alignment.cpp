// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Aligns two prepared maps, and evaluates given poses. */
#include <mrpt/core/exceptions.h>
#include <mrpt/core/format.h>
#include <mrpt/fusion/alignment.h>
#include <mrpt/system/CTicTac.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "fusion_core/features/features.h"
#include "fusion_core/pair/align_from.h"
#include "fusion_core/pair/match.h"
#include "fusion_core/pair/scaled_options.h"
#include "fusion_core/pair/verify.h"
#include "fusion_core/pair/wider_search.h"
#include "fusion_core/verdict/evaluation.h"

namespace mrpt::fusion {
namespace {

double secondsSince(mrpt::system::CTicTac& clock) {
  const double s = clock.Tac();
  clock.Tic();
  return s;
}

mrpt::poses::CPose3DPDFGaussian gaussian(const Eigen::Isometry3d& T, const Matrix6d& covariance) {
  return {toPose(T), mrpt::math::CMatrixDouble66(toYawPitchRollCovariance(covariance, T))};
}

Alignment sizesOf(const MapFeatures& a, const MapFeatures& b) {
  Alignment result;
  result.voxels_a = a.voxels.size();
  result.voxels_b = b.voxels.size();
  result.edges_a = a.edges.size();
  result.edges_b = b.edges.size();
  result.scale = std::max(a.scale, b.scale);
  return result;
}

/** Stages count voxels by int: refuses poses and voxel sizes with which that is not enough. */
void checkReach(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                const std::string& what) {
  constexpr double kGridSide = 65536, kLargestRatio = 1000;
  const double voxel_a = a.voxels.resolution, voxel_b = b.voxels.resolution;
  ASSERTMSG_(std::max(voxel_a, voxel_b) <= kLargestRatio * std::min(voxel_a, voxel_b),
             "the voxels of one map are more than 1000 times as wide as those of the other");
  ASSERTMSG_(T_a_b.translation().cwiseAbs().maxCoeff() <= kGridSide * (voxel_a + voxel_b),
             what + " is farther away than the maps can reach");
}

/** Least bound of the heading of a guess, rad: no heading is known better. */
constexpr double kLeastHeadingBound = M_PI / 180;

/** Rejects a match whose pose lies outside of the standard deviations that the guess states. The
 * search keeps to them, the registration need not. A position is never known better than to a cell
 * of the search. A guess states the position of the origin of map B, and the search moves the
 * middle of map B: the smaller of both distances counts, and of both heights. */
void rejectOutside(const MapFeatures& b, const Eigen::Isometry3d& guess, const SearchParams& search,
                   Alignment& result) {
  Evaluation& e = result.evaluation;
  if (e.pairs == 0)
    return e.reject("the maps do not touch anywhere within the bounds of the guess");
  const Eigen::Isometry3d& T = result.match.T_a_b;
  const Eigen::Vector3d middle = meanOf(b.matched.voxels.centre);
  const Eigen::Vector3d of_origin = T.translation() - guess.translation(),
                        of_middle = T * middle - guess * middle;
  const double far = std::min(of_origin.head<2>().norm(), of_middle.head<2>().norm());
  const double high = std::min(std::abs(of_origin.z()), std::abs(of_middle.z()));
  const Eigen::Matrix3d R = T.linear() * guess.linear().transpose();
  const double turn = std::abs(std::atan2(R(1, 0), R(0, 0)));
  const double most_high = std::max(search.height, search.cell);
  const double most_turn = std::max(search.yaw, kLeastHeadingBound);
  if (far <= search.translation && high <= most_high && turn <= most_turn) return;
  e.reject(mrpt::format(
      "the pose is %.2f m (height %.2f m) and %.1f deg from the guess, whose %.0f standard "
      "deviations allow %.2f m (height %.2f m) and %.1f deg",
      far, high, mrpt::RAD2DEG(turn), kSearchSigmas, search.translation, most_high,
      mrpt::RAD2DEG(most_turn)));
}

/** Adds a reason if the match lies outside of the search around a guess without deviations. */
void compareWithGuess(const MapFeatures& b, const Eigen::Isometry3d& guess,
                      const SearchParams& search, Alignment& result) {
  Evaluation& e = result.evaluation;
  const Eigen::Vector3d middle = meanOf(b.matched.voxels.centre);
  const Eigen::Isometry3d& T = result.match.T_a_b;
  const Eigen::Vector3d step = T * middle - guess * middle;
  const double angle = Eigen::AngleAxisd(T.linear() * guess.linear().transpose()).angle();
  const double largest_angle = std::min(search.yaw + search.levelling.max_tilt, M_PI);
  if (step.head<2>().norm() <= 2 * search.translation && angle <= largest_angle) return;
  e.addReasonAgainst(mrpt::format("the middle of map B is %.1f m and %.0f deg from the guess",
                                  step.norm(), angle * 180 / M_PI));
}

}  // namespace

mrpt::poses::CPose3DPDFGaussian Alignment::pose() const {
  return gaussian(match.T_a_b, match.covariance);
}

mrpt::poses::CPose3DPDFSOG Alignment::hypotheses() const {
  std::vector<RankedPose> possible = match.hypotheses;
  while (!possible.empty() && possible.back().agreement <= 0)
    possible.pop_back();  // the logarithm needs a positive agreement
  mrpt::poses::CPose3DPDFSOG modes(possible.size());
  std::transform(possible.begin(), possible.end(), modes.begin(), [](const RankedPose& h) {
    mrpt::poses::CPose3DPDFSOG::TGaussianMode mode;
    mode.val = gaussian(h.T_a_b, h.covariance);
    mode.log_w = std::log(h.agreement);
    return mode;
  });
  return modes;
}

Alignment align(const PreparedMap& map_a, const PreparedMap& map_b, const Prior& prior,
                const Options& options, const OnIteration& on_iteration) {
  const Eigen::Isometry3d guess = toEigen(prior.guess());
  ASSERTMSG_(guess.matrix().allFinite(), "the initial guess is not a pose");
  const bool by_edges = map_a.isEdgesAlone() || map_b.isEdgesAlone();
  const MapFeatures& a = by_edges ? map_a.featuresByEdges() : map_a.features();
  const MapFeatures& b = by_edges ? map_b.featuresByEdges() : map_b.features();
  ASSERTMSG_(a.voxels.size() > 0, "map A has no occupied voxel");
  ASSERTMSG_(b.voxels.size() > 0, "map B has no occupied voxel");
  checkReach(a, b, guess, "the initial guess");

  mrpt::system::CTicTac clock;
  Alignment result = sizesOf(a, b);
  result.by_edges = by_edges;
  Options within_prior = scaledBy(options, result.scale);
  within_prior.search = prior.searchWithin(within_prior.search);
  result.match = matchMaps(a, b, guess, within_prior, on_iteration);
  result.seconds_matching = secondsSince(clock);

  result.evaluation = judgeAndSearchWider(a, b, prior, within_prior, result.match);
  const bool is_near_guess =
      within_prior.search.translation > 0 && !within_prior.search.isEverywhere();
  if (is_near_guess && prior.statesCovariance())
    rejectOutside(b, guess, within_prior.search, result);
  else if (is_near_guess)
    compareWithGuess(b, guess, within_prior.search, result);
  if (by_edges)
    result.evaluation.reject(
        "a match of edges alone estimates the pose; it cannot show that the maps may be merged");
  result.seconds_evaluation = secondsSince(clock);
  return result;
}

double coarseAgreement(const PreparedMap& map_a, const PreparedMap& map_b, const Prior& prior,
                       const Options& options) {
  const MapFeatures &a = map_a.features(), &b = map_b.features();
  const Eigen::Isometry3d guess = toEigen(prior.guess());
  checkReach(a, b, guess, "the initial guess");
  Options within_prior = scaledBy(options, std::max(a.scale, b.scale));
  within_prior.search = prior.searchWithin(within_prior.search);
  return coarseAgreement(a, b, guess, within_prior);
}

Alignment alignFrom(const PreparedMap& map_a, const PreparedMap& map_b,
                    const Eigen::Isometry3d& T_a_b, const Options& unscaled) {
  map_a.wholeMap();
  map_b.wholeMap();
  const MapFeatures &a = map_a.features(), &b = map_b.features();
  Alignment result = sizesOf(a, b);
  const Options options = scaledBy(unscaled, result.scale);
  result.match = matchFrom(a, b, T_a_b, options);
  result.evaluation = judge(a, b, result.match, options.evaluation);
  return result;
}

Alignment evaluate(const PreparedMap& map_a, const PreparedMap& map_b,
                   const mrpt::poses::CPose3D& pose, const Options& unscaled) {
  map_a.wholeMap();
  map_b.wholeMap();
  mrpt::system::CTicTac clock;
  const MapFeatures &a = map_a.features(), &b = map_b.features();
  const Eigen::Isometry3d T_a_b = toEigen(pose);
  checkReach(a, b, T_a_b, "the pose");
  Alignment result = sizesOf(a, b);
  const Options options = scaledBy(unscaled, result.scale);
  result.match = matchAt(a, b, T_a_b, options);
  result.evaluation = verify(a, b, options, result.match);
  result.seconds_evaluation = secondsSince(clock);
  return result;
}

}  // namespace mrpt::fusion
