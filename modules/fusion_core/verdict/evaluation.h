// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/match_result.h>

#include <Eigen/Geometry>
#include <cstddef>

#include "fusion_core/features/features.h"
#include "fusion_core/map/map_voxels.h"

/** \file
 * Judging a match: eqs. (23)-(25), joined by free space, rivals and how firmly the pose is held. */

namespace mrpt::fusion {

/** Eq. (25): the overlap Theta, mean share of matched voxels in both maps, [0,1]. */
double overlapOf(double matches, double voxels_a, double voxels_b);

/** The least inlier ratio accepted at an overlap (the list after eq. 25), by default: 0.8 up to
 * Theta = 0.2, 0.9 - Theta / 2 up to 0.6, then 0.6. The paper's Fig. 9: 0.7 at 0.4. */
double acceptanceThreshold(double overlap, const EvaluationParams& params = {});

/** The probability that a pose is off by at most the tolerance, each part a Gaussian error in the
 * direction that is known least. */
double probabilityOfStaying(const PoseDeviation& deviation, const PoseTolerance& tolerance = {});

/** Looks occupied voxels of B up in map A, one way: every \a stride -th.
 * O(voxels of B / stride). */
FreeSpaceCheck checkFreeSpace(const MapVoxels& a, const OccupiedVoxels& b,
                              const Eigen::Isometry3d& T_a_b, size_t stride = 1);

/** Eqs. (23)-(25) on the pairs of a match, joined by what they ignore: a wrong pose can lay floor
 * on floor, but it puts walls where the other robot has seen free space.
 * \param[in] a,b The maps A and B. \param[in] pairs Pairs of voxels at T_a_b, gated as in matching,
 * of params.voxels of B's voxels. \param[in] T_a_b Pose of map B in A's frame. \param[in] params
 * What is accepted. \param[in] runner_up See MatchResult::runnerUp(). \param[in] deviation Of the
 * pose: a corridor without features matches well, but slides. */
Evaluation evaluateMatch(const MapVoxels& a, const MapVoxels& b, const Pairs& pairs,
                         const Eigen::Isometry3d& T_a_b, const EvaluationParams& params,
                         double runner_up = 0, const PoseDeviation& deviation = {});

/** The verdict on a match by what the match holds: evaluateMatch() with its pairs, its rivals and
 * its covariance. Only judges: it neither searches nor changes the match. */
Evaluation judge(const MapFeatures& a, const MapFeatures& b, const MatchResult& match,
                 const EvaluationParams& params);

}  // namespace mrpt::fusion
