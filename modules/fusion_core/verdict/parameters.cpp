// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Lists keys, ranges and meanings of the parameters of ranking and verdict. */
#include "fusion_core/verdict/parameters.h"

namespace mrpt::fusion {

Parameters parametersOf(RankingParams& params) {
  AgreementParams& a = params.agreement;
  return {
      advanced(
          count("ranking_few_voxels", params.few_voxels, 1, kUnlimited,
                "Voxels of each map by which all poses are compared, if there are many poses")),
      advanced(count("ranking_many_voxels", params.many_voxels, 1, kUnlimited,
                     "Voxels of each map by which the best poses are compared")),
      advanced(count("ranking_max_starts", params.max_starts, 1, kUnlimited,
                     "Most poses that are compared by ranking_many_voxels")),
      advanced(count("ranking_rival_voxels", params.rival_voxels, 1, kUnlimited,
                     "Voxels of each map by which rivals of the best pose are compared")),
      advanced(count("ranking_max_rivals", params.max_rivals, 1, kUnlimited,
                     "Most poses that are compared by ranking_rival_voxels")),
      advanced(number("ranking_min_rival_agreement", params.min_rival_agreement, 0, 1,
                      "Least agreement of a rival over that of the best pose")),
      advanced(count("ranking_iterations", params.max_iterations, 1, kUnlimited,
                     "Most iterations for a pose that is compared")),
      advanced(length("ranking_min_step_translation", params.min_step_translation, 0, kUnlimited,
                      "A comparison has converged when an iteration moves less than this, m,")),
      advanced(angle("ranking_min_step_rotation_deg", params.min_step_rotation, 0, 180,
                     "and less than this, deg")),
      advanced(
          number("ranking_moved_share", params.moved_share, 0, kUnlimited,
                 "A pose that all voxels moved by more is compared again, times the tolerance")),
      advanced(number("agreement_tolerance", a.tolerance, 1e-6, kUnlimited,
                      "Share of obstacles in free space that leaves 1/e of the agreement")),
      advanced(number("agreement_other_side", a.other_side, 0, 1,
                      "Weight of an obstacle that the other map sees from the other side")),
      advanced(number("agreement_front_voxels", a.front_voxels, 0, 100,
                      "Distance of the free space before an obstacle, voxels")),
      advanced(number("agreement_missed", a.missed, 0, 1,
                      "Weight of an obstacle beside the obstacles of a map without free space")),
  };
}

Parameters parametersOf(EvaluationParams& params) {
  return {
      count("evaluation_voxels", params.voxels, 0, kUnlimited,
            "Number of voxels of each map, evenly spread, that the verdict uses; 0: all"),
      length("inlier_mahalanobis", params.inlier_mahalanobis, 0, kUnlimited,
             "Pairs below this Mahalanobis distance are inliers"),
      number("max_free_conflict", params.max_free_conflict, 0, 1,
             "Largest share of obstacles that lie in the other map's free space, those at its "
             "border in part; 1: not tested"),
      advanced(number("border_weight", params.border.weight, 0, 1,
                      "Weight of a conflict at the border of free and unknown space")),
      advanced(length("border_voxel", params.border.largest_voxel, 0, kUnlimited,
                      "In maps of larger voxels all conflicts have weight 1, m")),
      number("min_overlap", params.min_overlap, 0, 1,
             "Least overlap, eq. (25), of an accepted match"),
      number("min_probability", params.min_probability, 0, 1,
             "Least probability of being right; 0: not tested"),
      number("sure_probability", params.sure_probability, 0, 1,
             "The search goes farther from a guess while the match is less probable; 0: never"),
      number("max_runner_up", params.max_runner_up, 0, 1,
             "Largest agreement of the second best pose over that of the best; 1: not tested"),
      advanced(number("min_rival_support", params.min_rival_support, 1e-6, 1,
                      "Rivals that confirm less, over what the match confirms, count less")),
      advanced(number("other_side_rival", params.other_side_rival, 0, 1,
                      "Weight of a rival that is confirmed only from the other side")),
      advanced(number("threshold_without_overlap", params.threshold_without_overlap, 0, 2,
                      "Least inlier ratio at no overlap, before the two limits")),
      advanced(number("threshold_per_overlap", params.threshold_per_overlap, 0, 2,
                      "Decrease of the least inlier ratio with the overlap")),
      advanced(number("min_threshold", params.min_threshold, 0, 1,
                      "Lower limit of the least inlier ratio")),
      advanced(number("max_threshold", params.max_threshold, 0, 1,
                      "Upper limit of the least inlier ratio")),
      advanced(
          number("max_size_difference", params.max_size_difference, 0, kUnlimited,
                 "Largest relative difference of the sizes of the maps that is not looked at")),
      advanced(number("held_probability", params.held_probability, 0, 1,
                      "Least probability of staying in place that needs no remark")),
      advanced(length("tolerance_translation", params.tolerance.translation, 1e-3, kUnlimited,
                      "A pose is right within this distance, m,")),
      advanced(angle("tolerance_rotation_deg", params.tolerance.rotation, 1e-3, 180,
                     "and within this angle, deg")),
  };
}

Parameters parametersOf(VerdictModel& model) {
  return {
      count("version", model.version, 1, kUnlimited, "Version of the fit"),
      number("constant", model.constant, -kUnlimited, kUnlimited, "Log-odds without any evidence"),
      number("log_overlap", model.log_overlap, -kUnlimited, kUnlimited,
             "Log-odds per natural logarithm of the overlap"),
      number("conflict_ratio", model.conflict_ratio, -kUnlimited, kUnlimited,
             "Log-odds per share of obstacles in the other map's free space"),
      number("runner_up", model.runner_up, -kUnlimited, kUnlimited,
             "Log-odds per agreement of the best other pose over this pose's"),
      number("inlier_ratio", model.inlier_ratio, -kUnlimited, kUnlimited,
             "Log-odds per share of inliers"),
      number("min_overlap", model.min_overlap, 1e-9, 1, "Overlaps below this count as this"),
  };
}

}  // namespace mrpt::fusion
