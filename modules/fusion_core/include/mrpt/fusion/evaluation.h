// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/voxels.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "fusion_core/registration/optimization.h"

/** \file
 * The paper's Sec. V-A: can a match be trusted? */

namespace mrpt::fusion {

/** What a match must be like to be accepted. */
struct EvaluationParams {
  double inlier_mahalanobis = 0.2;  ///< a pair below this distance (not squared) is an inlier
  double max_free_conflict = 0.10;  ///< largest share of voxels found in the other's free space
  double min_overlap = 0.02;        ///< least overlap; below it there is nothing to judge by
  /** Largest agreement of another pose, as a share of that of the pose found. */
  double max_runner_up = 0.75;
  double min_probability = 0.85;  ///< of being right, see probabilityOfBeingRight()
  /** A match from a guess that is accepted with less than this probability is compared with all
   * other poses, see judgeMatch(). 0: never. */
  double sure_probability = 0.985;
};

/** Voxels that one map has occupied, at their place in the other map. */
struct FreeSpaceCheck {
  size_t agreeing = 0;     ///< the other has them occupied too, or a neighbouring voxel
  size_t conflicting = 0;  ///< the other has seen that place and all around it free of obstacles
  /** Share that conflicts, [0,1]; 0 if there are none. */
  double conflictRatio() const {
    const size_t n = agreeing + conflicting;
    return n > 0 ? static_cast<double>(conflicting) / static_cast<double>(n) : 0;
  }
};

/** What evaluateMatch() found. */
struct Evaluation {
  size_t asked = 0;             ///< voxels of map B that were to be paired
  size_t pairs = 0;             ///< of them that were: N_match, if all were asked
  size_t inliers = 0;           ///< pairs below EvaluationParams::inlier_mahalanobis
  double overlap = 0;           ///< Theta, eq. (25), [0,1]
  double inlier_ratio = 0;      ///< inliers / pairs
  double threshold = 1;         ///< least inlier ratio that is accepted, from Theta
  double mean_mahalanobis = 0;  ///< of the pairs
  double log_likelihood = 0;    ///< log of eq. (23)
  FreeSpaceCheck free_space;    ///< both directions together, of the voxels asked
  double runner_up = 0;         ///< agreement of the best other pose over that of this one
  bool is_ambiguous = false;    ///< that one is all that speaks against it
  PoseDeviation deviation;      ///< how firmly the pairs hold map B in place
  double probability = 0;       ///< that the pose is right, [0,1]
  /** The verdict. */
  bool accepted = false;
  std::vector<std::string> reasons;  ///< for the verdict, one sentence each
};

/** The square root of eq. (24)'s exponent: |m - s| / sqrt(1/p_m + 1/p_s). Published without unit;
 * the distance is taken in metres: 0.2 is 0.29 m at p = 0.97. */
double mahalanobisDistance(double squared_distance, double p_model, double p_scene);

/** Eq. (25): the overlap Theta, mean share of matched voxels in both maps, [0,1]. */
double overlapOf(double matches, double model_voxels, double scene_voxels);

/** The least inlier ratio accepted at an overlap (the list after eq. 25): 0.8 up to Theta = 0.2,
 * 0.9 - Theta / 2 up to 0.6, then 0.6. The paper's Fig. 9: 0.7 at 0.4. */
double acceptanceThreshold(double overlap);

/** The probability that a pose is right (within 0.6 m and 6 deg; not in the paper, whose test a
 * shift by one row of pillars passes), of what tells right ones from wrong ones: overlap, eq. (25),
 * share of obstacles in the other map's free space, agreement of the best other pose over that of
 * this one, and inlier ratio; all [0,1]. A logistic regression on matches of simulated buildings,
 * cut to overlaps down to none, mirrored, or of two buildings: see doc/choices.md. */
double probabilityOfBeingRight(double overlap, double conflict_ratio, double runner_up,
                               double inlier_ratio);

/** The probability that a pose is off by at most 0.6 m and 6 deg, each a Gaussian error in the
 * direction that is known least. */
double probabilityOfStaying(const PoseDeviation& deviation);

/** See findingAt(). */
enum class Finding : uint8_t {
  Unknown,   ///< the map does not know the place
  Agrees,    ///< it has an obstacle there or in a voxel beside
  Conflicts  ///< it has seen the place free, and all around it
};

/** What a map says of an obstacle at a point (m, the map's frame). Only a place seen free with
 * nothing occupied around it contradicts: half a voxel of quantisation in each map is no
 * contradiction. */
Finding findingAt(const MapVoxels& map, const Eigen::Vector3d& p);

/** Of how many voxels of a map the verdict asks by default: shares of so many are known to less
 * than half a percent (one standard deviation). */
constexpr unsigned kVoxelsOfVerdict = 15000;

/** Looks occupied voxels of the scene up in the model, one way: every \a stride -th.
 * O(voxels of the scene / stride). */
FreeSpaceCheck checkFreeSpace(const MapVoxels& model, const OccupiedVoxels& scene,
                              const Eigen::Isometry3d& T_model_scene, size_t stride = 1);

/** Eqs. (23)-(25) on the pairs of a match, joined by what they ignore: a wrong pose can lay floor
 * on floor, but it puts walls where the other robot has seen free space. \param[in] a,b The maps A
 * and B. \param[in] pairs Of voxels at T_a_b, gated as in matching. \param[in] T_a_b Pose of map B
 * in A's frame. \param[in] params What is accepted. \param[in] runner_up See
 * MatchResult::runnerUp(). \param[in] deviation Of the pose: a corridor without features matches
 * well, but slides. \param[in] enough Of each map so many voxels are asked, and of B's those were
 * paired, see strideFor().
 */
Evaluation evaluateMatch(const MapVoxels& a, const MapVoxels& b, const Pairs& pairs,
                         const Eigen::Isometry3d& T_a_b, const EvaluationParams& params,
                         double runner_up = 0, const PoseDeviation& deviation = {},
                         size_t enough = kVoxelsOfVerdict);

}  // namespace mrpt::fusion
