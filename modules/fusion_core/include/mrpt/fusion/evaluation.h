// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/fusion/match_result.h>

#include <cstddef>
#include <string>
#include <vector>

/** \file
 * The paper's Sec. V-A: the verdict on a match, its evidence and its parameters. */

namespace mrpt::fusion {

/** Largest error of a right pose: the paper's criterion of success. */
struct PoseTolerance {
  double translation = 0.6;               ///< Largest error of the position, m
  double rotation = 0.10471975511965977;  ///< Largest error of the rotation, rad (6 deg)
};

/** Logistic regression from the evidence of a verdict to its probability. It is fitted by
 * scripts/fit_verdict.py on matches of simulated buildings, see
 * doc/decisions/025-probability.md and, for the conflict ratio, 066-border-of-free-space.md. */
struct VerdictModel {
  unsigned version = 2;         ///< Version of the fit
  double constant = -15.57;     ///< Log-odds without evidence
  double log_overlap = 1.845;   ///< Log-odds per natural logarithm of the overlap
  double conflict_ratio = -50;  ///< Log-odds per FreeSpaceCheck::conflictRatio()
  double runner_up = -8.085;    ///< Log-odds per agreement of the best other pose over this pose's
  double inlier_ratio = 22.91;  ///< Log-odds per share of inliers
  double min_overlap = 1e-3;    ///< Least overlap; smaller overlaps count as this overlap

  /** Returns the probability that a pose is right within PoseTolerance. It is not in the paper: a
   * pose that is shifted by a row of pillars passes the paper's test. All measures are in [0,1].
   * \param[in] overlap Eq. (25).
   * \param[in] conflict_ratio See FreeSpaceCheck::conflictRatio().
   * \param[in] runner_up Weight of the best other pose, see Evaluation::rival_weight.
   * \param[in] inlier_ratio Inliers over pairs. */
  MRPT_FUSION_API double probability(double overlap, double conflict_ratio, double runner_up,
                                     double inlier_ratio) const;
};

/** Weight of conflicts at the border of the free space. A map of few or noisy returns has holes in
 * its surfaces. An obstacle of the other map that lies beside such a hole is in free space, without
 * an obstacle around, also at the right pose. */
struct BorderParams {
  /** Weight of an obstacle in a free voxel that has, along an axis, free space on one side and
   * unknown space on the other side, over a conflict, [0,1]. */
  double weight = 0.25;
  /** Largest voxel with such a border, m. A larger voxel is larger than a hole. */
  double largest_voxel = 0.15;
};

/** Settings of agreement(). */
struct AgreementParams {
  double tolerance = 0.02;    ///< Conflict ratio at which 1/e of the agreement is left
  double other_side = 0.05;   ///< Weight of an obstacle seen from the other side, [0,1]
  double front_voxels = 2.5;  ///< Distance of the free space in front of an obstacle, voxels
  /** Weight of an obstacle beside the obstacles of a map without free space, over a conflict. */
  double missed = 0.1;
};

/** Settings of the comparison of hypotheses: numbers of poses and voxels, precision. */
struct RankingParams {
  size_t few_voxels = 250;             ///< Voxels of each map for all poses, if they are many
  size_t many_voxels = 1000;           ///< Voxels of each map for the best poses
  size_t max_starts = 24;              ///< Largest number of poses compared by many_voxels
  size_t rival_voxels = 5000;          ///< Voxels of each map for rivals of the best pose
  size_t max_rivals = 4;               ///< Largest number of poses compared by rival_voxels
  double min_rival_agreement = 0.05;   ///< Least agreement of a rival over that of the best pose
  unsigned max_iterations = 15;        ///< Largest number of iterations for each pose
  double min_step_translation = 0.01;  ///< Least step of an iteration, translation, m
  double min_step_rotation = 0.002;    ///< Least step of an iteration, rotation, rad
  /** Largest step of the registration with all voxels, as a share of PoseTolerance. After a larger
   * step the pose is compared again. */
  double moved_share = 1.0 / 3;
  AgreementParams agreement;  ///< Measure of the comparison
};

/** Settings of the verdict: conditions of an accepted match. */
struct EvaluationParams {
  unsigned voxels =
      15000;  ///< Voxels of each map in the verdict, spread evenly; 0: all, as published
  double inlier_mahalanobis = 0.2;  ///< Mahalanobis distance (not squared) of an inlier
  double max_free_conflict = 0.10;  ///< Largest conflict ratio
  BorderParams border;              ///< Weight of some conflicts
  double min_overlap = 0.02;        ///< Least overlap; a smaller overlap has too little evidence
  /** Largest agreement of another pose over the agreement of the match. */
  double max_runner_up = 0.75;
  /** Least support of a rival. A pose that lays the maps beside each other has no conflicts and may
   * agree well, but it confirms next to nothing. A rival with less support counts in proportion,
   * unless it agrees better than the match. */
  double min_rival_support = 0.05;
  /** Weight of a rival whose support is from the other side, [0,1]: below min_rival_support of the
   * obstacles are seen from the same side. Such a rival lays the rooms of both maps back to back,
   * so it is no other place in the rooms of the match. */
  double other_side_rival = 0.25;
  double min_probability = 0.85;  ///< Least probability that the pose is right
  /** Least probability of an accepted match that ends the search near a guess, see align(). 0: the
   * search never goes farther. */
  double sure_probability = 0.985;
  double threshold_without_overlap = 0.9;  ///< Inlier threshold at overlap 0, before its limits
  double threshold_per_overlap = 0.5;      ///< Decrease of the inlier threshold per overlap
  double min_threshold = 0.6;              ///< Least inlier threshold
  double max_threshold = 0.8;              ///< Largest inlier threshold
  /** Largest logarithm of the size of B over the size of A. A larger difference that is also clear
   * (3 standard deviations) is a difference of units or a faulty scale. */
  double max_size_difference = 0.02;
  double held_probability = 0.95;  ///< Least probability of staying in place without a remark
  PoseTolerance tolerance;         ///< Largest error of a right pose
  VerdictModel model;              ///< Model from evidence to probability
};

/** Occupied voxels of one map, compared with the other map at the same places. A map without free
 * space cannot show a conflict: what it confirms is counted a second time, in
 * agreeing_without_free. */
struct FreeSpaceCheck {
  size_t agreeing = 0;     ///< Number of voxels with an obstacle there or in a neighbouring voxel
  size_t conflicting = 0;  ///< Number of voxels in seen free space without an obstacle around
  size_t agreeing_without_free = 0;  ///< Part of agreeing that maps without free space confirm
  /** Number of voxels beside the obstacles of a map without free space: 2 to 4 voxels away. */
  size_t missed = 0;
  /** Part of conflicting that does not count: obstacles at the border of the free space count less,
   * see BorderParams. */
  double discount = 0;

  /** Returns the sum of each number. */
  FreeSpaceCheck operator+(const FreeSpaceCheck& other) const {
    FreeSpaceCheck sum = *this;
    sum.agreeing += other.agreeing;
    sum.conflicting += other.conflicting;
    sum.agreeing_without_free += other.agreeing_without_free;
    sum.missed += other.missed;
    sum.discount += other.discount;
    return sum;
  }
  /** True if an obstacle lies where the other map has free space around and could show a conflict.
   * Without such obstacles the conflict ratio is no evidence. */
  bool knowsConflicts() const { return conflicting + agreeing > agreeing_without_free; }
  /** Conflict ratio, [0,1]: c / (c + a), where c is conflicting less discount, and a is agreeing
   * less agreeing_without_free. 0 if nothing is known. */
  double conflictRatio() const {
    return ratio(static_cast<double>(conflicting) - discount, agreeing - agreeing_without_free);
  }
  /** Ratio of missed voxels in maps without free space, [0,1]; 0 if both maps have free space. */
  double missedRatio() const { return ratio(static_cast<double>(missed), agreeing_without_free); }

 private:
  static double ratio(double against, size_t in_favour) {
    const double n = against + static_cast<double>(in_favour);
    return n > 0 ? against / n : 0;
  }
};

/** How a pose was compared with other poses. */
enum class OtherPoses {
  NotSearched,  ///< No other pose was searched
  NoneBetter,   ///< A search found no pose that agrees clearly better, and no more is known
  Compared      ///< The best other pose is known, or there is none
};

/** The verdict on a match, with its evidence. */
struct Evaluation {
  size_t sampled = 0;             ///< Number of voxels of B to pair
  size_t pairs = 0;               ///< Number of pairs: N_match, if all voxels of B are used
  size_t inliers = 0;             ///< Number of pairs below EvaluationParams::inlier_mahalanobis
  double overlap = 0;             ///< Overlap Theta, eq. (25), [0,1]
  double inlier_ratio = 0;        ///< Inliers over pairs, [0,1]
  double threshold = 1;           ///< Least accepted inlier ratio at this overlap
  double mean_mahalanobis = 0;    ///< Mean Mahalanobis distance of the pairs
  double log_likelihood = 0;      ///< Logarithm of eq. (23)
  FreeSpaceCheck free_space;      ///< Sum of both directions, for the voxels in the verdict
  double without_free_space = 0;  ///< Share of the maps without free space: 0, 0.5 or 1
  /** What runner_up and rival_weight are worth: they are evidence only if poses were compared. */
  OtherPoses other_poses = OtherPoses::NotSearched;
  double runner_up = 0;  ///< Agreement of the best rival over the agreement of this pose
  /** Obstacles that the maps confirm at the pose of the best rival, over those that they confirm at
   * this pose, at most 1. 1 if the verdict did not look at it: the match is sure anyway. */
  double rival_support = 1;
  /** The same ratio for the obstacles that both maps see from the same side. */
  double rival_same_side = 1;
  /** Weight of the best rival against the pose: runner_up, less if the rival has too little
   * support, see EvaluationParams::min_rival_support and other_side_rival. */
  double rival_weight = 0;
  bool is_ambiguous = false;  ///< True if a rival is the only reason for the rejection
  SizeRatio size_ratio;       ///< Size of map B over the size of map A
  PoseDeviation deviation;    ///< Standard deviations of the pose
  double probability = 0;     ///< Probability that the pose is right, [0,1]
  /** True if the pose can be trusted. */
  bool accepted = false;
  /** Reasons of the verdict, one sentence each: first all reasons against the pose. */
  std::vector<std::string> reasons;
  size_t reasons_against = 0;  ///< Number of reasons against the pose, or of lacking evidence

  /** Returns the reasons against the pose, or of lacking evidence. */
  std::vector<std::string> against() const {
    return {reasons.begin(), reasons.begin() + static_cast<std::ptrdiff_t>(reasons_against)};
  }
  /** Adds a reason behind the other reasons against the pose. */
  void addReasonAgainst(const std::string& reason) {
    reasons.insert(reasons.begin() + static_cast<std::ptrdiff_t>(reasons_against++), reason);
  }
  /** Rejects the match for a reason that other poses do not change. */
  void reject(const std::string& reason) {
    accepted = is_ambiguous = false;
    addReasonAgainst(reason);
  }
  /** Adds a reason for the pose. */
  void addReasonFor(const std::string& reason) { reasons.push_back(reason); }
};

/** Returns the square root of the exponent of eq. (24): |a - b| / sqrt(1/p_a + 1/p_b). The paper
 * gives no unit. Here the distance is in m: a result of 0.2 is 0.29 m at p = 0.97.
 * \param[in] squared_distance Squared distance of the pair, m^2.
 * \param[in] p_a,p_b Probabilities of being occupied, (0,1]. */
MRPT_FUSION_API double mahalanobisDistance(double squared_distance, double p_a, double p_b);

}  // namespace mrpt::fusion
