// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Searches farther from a guess while the match is not sure. */
#include "fusion_core/pair/wider_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fusion_core/pair/match.h"
#include "fusion_core/verdict/evaluation.h"
#include "fusion_core/verdict/hypotheses.h"

namespace mrpt::fusion {
namespace {

bool isSure(const Evaluation& e, const EvaluationParams& params) {
  return e.accepted && e.probability >= params.sure_probability;
}

/** A match and its verdict. */
struct Judged {
  MatchResult match;
  Evaluation evaluation;
};

/** Returns the better of a match and the match of a wider search. */
Judged better(const MapFeatures& a, const MapFeatures& b, const Options& options, Judged near,
              MatchResult wide) {
  const EvaluationParams& params = options.evaluation;
  const ComparisonParams comparison = comparisonOf(options);
  const bool is_rejected = !near.evaluation.accepted;
  if (isSamePlace(near.match.T_a_b, wide.T_a_b, meanOf(b.matched.voxels.centre),
                  params.tolerance)) {
    if (!is_rejected) return near;
    const Evaluation of_wide = judge(a, b, wide, params);
    if (of_wide.accepted || of_wide.probability > near.evaluation.probability)
      return {std::move(wide), of_wide};
    return near;
  }
  const auto other =
      betterPoseElsewhere(a, b, near.match.T_a_b, wide.T_a_b, params.max_runner_up, comparison);
  if (!other) return near;
  // The match near the guess is one of the rivals of the wide match.
  addRival(b, {near.match.T_a_b, 0, near.match.covariance}, other->of_match / other->pose.agreement,
           params.tolerance, wide);
  const Evaluation of_wide = judge(a, b, wide, params);
  if (of_wide.accepted || (is_rejected && of_wide.probability > near.evaluation.probability))
    return {std::move(wide), of_wide};
  insertBetter(*other, near.match);
  near.evaluation = judge(a, b, near.match, params);
  return near;
}

}  // namespace

bool isTooTilted(const Eigen::Isometry3d& T_a_b, const Eigen::Isometry3d& guess,
                 const SearchParams& search) {
  if (search.rotations == SearchRotations::All) return false;
  const auto verticalOfAInB = [](const Eigen::Isometry3d& T) -> Eigen::Vector3d {
    return T.linear().row(2).transpose();
  };
  return verticalOfAInB(T_a_b).dot(verticalOfAInB(guess)) < std::cos(search.levelling.max_tilt);
}

std::vector<SearchParams> widerSearches(const Prior& prior, const Options& options) {
  const SearchParams& near = options.search;
  if (near.translation <= 0 || near.isEverywhere() || options.evaluation.sure_probability <= 0)
    return {};
  SearchParams of_more = near;
  of_more.hypotheses = everywhere(near).hypotheses;
  if (prior.statesCovariance()) return {of_more};
  return {of_more, everywhere(near)};
}

Evaluation judgeAndSearchWider(const MapFeatures& a, const MapFeatures& b, const Prior& prior,
                               const Options& options, MatchResult& result) {
  Judged best{std::move(result), {}};
  best.evaluation = judge(a, b, best.match, options.evaluation);
  if (!isEmpty(a, b))
    for (const SearchParams& search : widerSearches(prior, options)) {
      if (isSure(best.evaluation, options.evaluation)) break;
      Options wider = options;
      wider.search = search;
      MatchResult wide = matchMaps(a, b, toEigen(prior.guess()), wider);
      if (isTooTilted(wide.T_a_b, toEigen(prior.guess()), search)) continue;
      best = better(a, b, options, std::move(best), std::move(wide));
    }
  result = std::move(best.match);
  return best.evaluation;
}

}  // namespace mrpt::fusion
