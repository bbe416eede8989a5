// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/fusion/match_result.h>

#include <cstddef>
#include <string>
#include <vector>

/** \file
 * The paper's Sec. V-A: can a match be trusted? */

namespace mrpt::fusion {

/** How far from the truth a pose may be to count as right: the paper's criterion of success. */
struct PoseTolerance {
  double translation = 0.6;               ///< m
  double rotation = 0.10471975511965977;  ///< rad (6 deg)
};

/** How a verdict's probability follows from its evidence: a logistic regression on matches of
 * simulated buildings, see doc/decisions/025-probability.md. scripts/fit_verdict.py fits it. */
struct VerdictModel {
  unsigned version = 1;            ///< Version of the fit
  double constant = -15.57;        ///< Log-odds without any evidence
  double log_overlap = 1.845;      ///< Log-odds per natural logarithm of the overlap
  double conflict_ratio = -29.31;  ///< Log-odds per share of obstacles in the other's free space
  double runner_up = -8.085;    ///< Log-odds per agreement of the best other pose over this pose's
  double inlier_ratio = 22.91;  ///< Log-odds per share of inliers
  double min_overlap = 1e-3;    ///< Overlaps below this count as this

  /** The probability that a pose is right within PoseTolerance, from four measures in [0,1]:
   * overlap, eq. (25), share of obstacles in the other map's free space, agreement of the best
   * other pose over that of this pose, and inlier ratio. Not in the paper, whose test a shift by a
   * row of pillars passes. */
  MRPT_FUSION_API double probability(double overlap, double conflict_ratio, double runner_up,
                                     double inlier_ratio) const;
};

/** How well two maps agree at a pose: settings of agreement(). */
struct AgreementParams {
  double tolerance = 0.02;    ///< Share of conflicts that leaves 1/e of the agreement
  double other_side = 0.05;   ///< Weight of an obstacle that is seen from the other side, [0,1]
  double front_voxels = 2.5;  ///< Distance of the free space before an obstacle, in voxels
};

/** Settings of the comparison of hypotheses: how many poses, by how many voxels, how finely. */
struct RankingParams {
  size_t few_voxels = 250;     ///< Voxels of each map for all poses, if there are many
  size_t many_voxels = 1000;   ///< Voxels of each map for the best poses
  size_t max_starts = 24;      ///< Most poses compared by many_voxels
  size_t rival_voxels = 5000;  ///< Voxels of each map for rivals: poses differ by more than chance
  size_t max_rivals = 4;       ///< Most poses compared by rival_voxels
  double min_rival_agreement = 0.05;   ///< Least agreement of a rival over that of the best pose
  unsigned max_iterations = 15;        ///< Most iterations for a pose that is compared
  double min_step_translation = 0.01;  ///< A comparison has converged below this step, m,
  double min_step_rotation = 0.002;    ///< and below this step, rad
  /** A pose that all voxels moved by more than this share of PoseTolerance is compared again. */
  double moved_share = 1.0 / 3;
  AgreementParams agreement;  ///< What the comparison is by
};

/** What a match must be like to be accepted. */
struct EvaluationParams {
  unsigned voxels =
      15000;  ///< Voxels of each map that are asked, spread evenly; 0: all, as published
  double inlier_mahalanobis = 0.2;  ///< A pair below this distance (not squared) is an inlier
  double max_free_conflict = 0.10;  ///< Largest share of obstacles in the other map's free space
  double min_overlap = 0.02;        ///< Least overlap; below it there is nothing to judge by
  /** Largest agreement of another pose, as a share of that of the pose found. */
  double max_runner_up = 0.75;
  double min_probability = 0.85;  ///< Least probability of being right
  /** A match from a guess that is accepted with less than this probability is compared with all
   * other poses, see verify(). 0: never. */
  double sure_probability = 0.985;
  double threshold_without_overlap = 0.9;  ///< Inlier threshold at no overlap, before its limits
  double threshold_per_overlap = 0.5;      ///< Decrease of the inlier threshold with the overlap
  double min_threshold = 0.6;              ///< Least inlier threshold
  double max_threshold = 0.8;              ///< Largest inlier threshold
  double held_probability = 0.95;  ///< Least probability of staying in place that needs no remark
  PoseTolerance tolerance;         ///< What counts as right
  VerdictModel model;              ///< From evidence to probability
};

/** Voxels of one map that are occupied, at their place in the other map. */
struct FreeSpaceCheck {
  size_t agreeing = 0;     ///< Occupied in the other map too, there or in a neighbouring voxel
  size_t conflicting = 0;  ///< Seen free in the other map, with all around it free of obstacles
  /** Share that conflicts, [0,1]; 0 if there are none. */
  double conflictRatio() const {
    const size_t n = agreeing + conflicting;
    return n > 0 ? static_cast<double>(conflicting) / static_cast<double>(n) : 0;
  }
};

/** The verdict on a match, with its evidence. */
struct Evaluation {
  size_t asked = 0;             ///< Voxels of map B that were to be paired
  size_t pairs = 0;             ///< Number of these that were paired: N_match, if all were asked
  size_t inliers = 0;           ///< Pairs below EvaluationParams::inlier_mahalanobis
  double overlap = 0;           ///< Theta, eq. (25), [0,1]
  double inlier_ratio = 0;      ///< Inliers over pairs, [0,1]
  double threshold = 1;         ///< Least inlier ratio that is accepted, from Theta
  double mean_mahalanobis = 0;  ///< Mean Mahalanobis distance of the pairs
  double log_likelihood = 0;    ///< Logarithm of eq. (23)
  FreeSpaceCheck free_space;    ///< Both directions together, of the voxels asked
  double runner_up = 0;         ///< Agreement of the best other pose over that of this pose
  bool is_ambiguous = false;    ///< True if another pose is all that speaks against this pose
  PoseDeviation deviation;      ///< How firmly the pairs hold map B in place
  double probability = 0;       ///< Probability that the pose is right, [0,1]
  /** The verdict. */
  bool accepted = false;
  std::vector<std::string> reasons;  ///< Reasons of the verdict, one sentence each
};

/** The square root of eq. (24)'s exponent: |a - b| / sqrt(1/p_a + 1/p_b). Published without a unit;
 * the distance is taken in metres: 0.2 is 0.29 m at p = 0.97.
 * \param[in] squared_distance m^2. \param[in] p_a,p_b Probabilities of being occupied, (0,1]. */
MRPT_FUSION_API double mahalanobisDistance(double squared_distance, double p_a, double p_b);

}  // namespace mrpt::fusion
