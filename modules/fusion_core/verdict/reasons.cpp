// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Decides on a match, and says why. */
#include "fusion_core/verdict/reasons.h"

#include <mrpt/core/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "fusion_base/percent_text.h"
#include "fusion_core/verdict/deviation_text.h"

namespace mrpt::fusion {
namespace {

/** Returns a pose as MRPT writes it, with a space before it; nothing for no pose. */
std::string textOf(const std::optional<Eigen::Isometry3d>& T) {
  if (!T) return "";
  const Eigen::Matrix3d R = T->linear();
  const double yaw = std::atan2(R(1, 0), R(0, 0)),
               pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0))),
               roll = std::atan2(R(2, 1), R(2, 2));
  const auto& t = T->translation();
  constexpr double kDegrees = 180 / M_PI;
  char text[160];
  std::snprintf(text, sizeof(text), " [%.2f %.2f %.2f %.1f %.1f %.1f]", t.x(), t.y(), t.z(),
                kDegrees * yaw, kDegrees * pitch, kDegrees * roll);
  return text;
}

/** Returns a factor with two digits. */
std::string factor(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2g", value);
  return text;
}

/** Adds one of two reasons. A bad figure rejects the match. */
void judge(bool is_good, const std::string& yes, const std::string& no, Evaluation& e) {
  if (is_good) return e.addReasonFor(yes);
  e.accepted = false;
  e.addReasonAgainst(no);
}

void judgeOverlap(const EvaluationParams& params, Evaluation& e) {
  if (e.pairs == 0) return judge(false, "", "the maps do not touch at this pose", e);
  const std::string overlap = "overlap " + percentBeside(params.min_overlap, e.overlap);
  judge(e.overlap >= params.min_overlap,
        overlap + " is at least " + percent(params.min_overlap) +
            ", below which maps are not compared",
        overlap + " is below " + percent(params.min_overlap), e);
  const std::string inliers = "inlier ratio " + percentBeside(e.threshold, e.inlier_ratio);
  judge(e.inlier_ratio > e.threshold, inliers + " is above its threshold " + percent(e.threshold),
        inliers + " is not above its threshold " + percent(e.threshold), e);
}

void judgeFreeSpace(const EvaluationParams& params, Evaluation& e) {
  const std::string missed = percent(e.free_space.missedRatio()) +
                             " of the obstacles lie beside the other map's obstacles";
  // A conflict ratio of 0 would read like evidence for the pose.
  if (e.without_free_space >= 1)
    return e.addReasonAgainst("neither map has free space to show conflicts: " + missed);
  if (!e.free_space.knowsConflicts()) {
    if (e.pairs > 0) e.addReasonAgainst("no obstacle lies where the other map has free space");
    return;
  }
  const double conflict = e.free_space.conflictRatio();
  const std::string limit = percent(params.max_free_conflict);
  const std::string border =
      e.free_space.discount > 0 ? mrpt::format(" (%g for each at its border)", params.border.weight)
                                : std::string();
  const std::string conflicting = percentBeside(params.max_free_conflict, conflict) +
                                  " of the obstacles lie in the other map's free space" + border +
                                  ", ";
  const std::string of_one =
      e.without_free_space > 0 ? "; one map has no free space: there " + missed : "";
  judge(conflict <= params.max_free_conflict,
        conflicting + "at most " + limit + " are allowed" + of_one,
        conflicting + "more than " + limit + of_one, e);
}

/** Rejects maps of clearly different sizes, and asks for the unit of very large voxels. */
void judgeSizes(const Circumstances& circumstances, const EvaluationParams& params, Evaluation& e) {
  constexpr double kDeviations = 3;
  constexpr double kLeastDoubtfulVoxel = 10;  // m
  const SizeRatio& ratio = e.size_ratio;
  char text[128];
  if (std::abs(std::log(ratio.value)) >
      std::max(params.max_size_difference, kDeviations * ratio.deviation / ratio.value)) {
    std::snprintf(text, sizeof(text),
                  "map B seems to be scaled by %.3f (standard deviation %.2g): do both maps have "
                  "the same unit?",
                  ratio.value, ratio.deviation);
    judge(false, "", text, e);
  }
  for (const auto& [name, voxel] :
       {std::pair('A', circumstances.voxel_a), std::pair('B', circumstances.voxel_b)}) {
    if (voxel < kLeastDoubtfulVoxel) continue;
    std::snprintf(text, sizeof(text),
                  "the voxels of map %c are %.4g m wide: are its lengths in millimetres?", name,
                  voxel);
    e.addReasonAgainst(text);
  }
}

/** Rejects maps that are dust. Voxels far apart show no surface, and where the points were made on
 * a grid, all maps fit each other at each step of the grid. */
void judgeDust(const Circumstances& circumstances, Evaluation& e) {
  constexpr double kMostLone = 0.9;
  for (const auto& [name, lone] :
       {std::pair('A', circumstances.lone_a), std::pair('B', circumstances.lone_b)})
    if (lone > kMostLone)
      judge(false, "",
            percentBeside(kMostLone, lone) + " of the occupied voxels of map " + name +
                " touch no other: they show no surfaces. Are its lengths in millimetres, or its "
                "voxels too small?",
            e);
}

void judgeRival(const Circumstances& circumstances, const EvaluationParams& params, Evaluation& e) {
  if (e.runner_up <= 0) return;
  const bool is_weak = e.rival_weight <= params.max_runner_up;
  const std::string pose = "another pose" + textOf(circumstances.rival);
  if (e.runner_up > 1)
    return judge(is_weak, pose + " agrees slightly better",
                 pose + " agrees better: this pose reaches only " + percent(1 / e.runner_up) +
                     " of its agreement",
                 e);
  const std::string limit = percent(params.max_runner_up);
  const std::string reaches = pose + " reaches " +
                              percentBeside(params.max_runner_up, e.runner_up) +
                              " of the agreement of this pose";
  if (e.rival_weight >= e.runner_up)
    return judge(is_weak, reaches + ", at most " + limit + " are allowed",
                 reaches + ", more than " + limit, e);
  const bool is_small = e.rival_support < params.min_rival_support;
  const std::string counts =
      reaches + ". It confirms only " + percent(is_small ? e.rival_support : e.rival_same_side) +
      " of the obstacles that this pose confirms" + (is_small ? "" : " from the same side") +
      ", so its agreement counts " + factor(e.rival_weight / e.runner_up) +
      " times: " + percentBeside(params.max_runner_up, e.rival_weight);
  judge(is_weak, counts + ", at most " + limit + " are allowed", counts + ", more than " + limit,
        e);
}

void judgeProbability(const Circumstances& circumstances, const EvaluationParams& params,
                      Evaluation& e) {
  if (e.pairs > 0 && circumstances.probability_of_staying < params.held_probability)
    e.addReasonAgainst("the shared surfaces do not fix the pose of map B: " + textOf(e.deviation));
  const std::string right = "the pose is right with a probability of " +
                            percentBeside(params.min_probability, e.probability);
  if (params.min_probability <= 0)
    return e.addReasonAgainst(right + ", which the settings do not test");
  judge(e.probability >= params.min_probability, right,
        right + ", below " + percent(params.min_probability), e);
}

}  // namespace

void decide(const Circumstances& circumstances, const EvaluationParams& params, Evaluation& e) {
  e.accepted = true;
  judgeOverlap(params, e);
  judgeFreeSpace(params, e);
  judgeSizes(circumstances, params, e);
  judgeDust(circumstances, e);
  e.is_ambiguous = e.accepted && e.rival_weight > params.max_runner_up &&
                   circumstances.probability_without_rival >= params.min_probability;
  judgeRival(circumstances, params, e);
  judgeProbability(circumstances, params, e);
}

}  // namespace mrpt::fusion
