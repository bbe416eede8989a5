// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Searches everywhere unless a given pose is surely right. */
#include "fusion_core/pair/verify.h"

#include "fusion_core/pair/match.h"
#include "fusion_core/verdict/evaluation.h"
#include "fusion_core/verdict/hypotheses.h"

namespace mrpt::fusion {

Evaluation verify(const MapFeatures& a, const MapFeatures& b, const Options& options,
                  MatchResult& result) {
  Evaluation evaluation = judge(a, b, result, options.evaluation);
  const bool has_bounds = options.search.translation > 0 && !options.search.isEverywhere();
  if (!has_bounds || isEmpty(a, b) || evaluation.probability >= options.evaluation.sure_probability)
    return evaluation;
  Options unbounded = options;
  unbounded.search = everywhere(options.search);
  const MatchResult elsewhere = matchMaps(a, b, result.T_a_b, unbounded);
  if (const auto better =
          betterPoseElsewhere(a, b, result.T_a_b, elsewhere.T_a_b, options.evaluation.max_runner_up,
                              comparisonOf(options))) {
    insertBetter(*better, result);
    evaluation = judge(a, b, result, options.evaluation);
  } else if (result.hypotheses.empty()) {
    evaluation.other_poses = OtherPoses::NoneBetter;
  }
  return evaluation;
}

}  // namespace mrpt::fusion
