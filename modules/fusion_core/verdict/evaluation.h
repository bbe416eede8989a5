// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/match_result.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <optional>

#include "fusion_core/features/features.h"
#include "fusion_core/map/map_voxels.h"

/** \file
 * The verdict on a match: eqs. (23)-(25), free space, rivals, and standard deviations. */

namespace mrpt::fusion {

/** Eq. (25): returns the overlap Theta, the mean share of matched voxels in both maps, [0,1]. */
double overlapOf(double matches, double voxels_a, double voxels_b);

/** Returns the least accepted inlier ratio at an overlap Theta (the list after eq. 25). Default:
 * 0.8 up to Theta = 0.2, 0.9 - Theta / 2 up to Theta = 0.6, 0.6 above. In the paper's Fig. 9 it is
 * 0.7 at Theta = 0.4. */
double acceptanceThreshold(double overlap, const EvaluationParams& params = {});

/** Returns the probability that the error of a pose is within the tolerance. The errors of position
 * and rotation are Gaussians in their least certain directions. */
double probabilityOfStaying(const PoseDeviation& deviation, const PoseTolerance& tolerance = {});

/** Compares every \a stride -th occupied voxel of B with map A. Cost: O(voxels of B / stride). */
FreeSpaceCheck checkFreeSpace(const MapVoxels& a, const OccupiedVoxels& b,
                              const Eigen::Isometry3d& T_a_b, size_t stride = 1,
                              const BorderParams& border = {});

/** The best other pose of a match. */
struct Rival {
  double ratio = 0;  ///< Agreement over the agreement of the match, see MatchResult::runnerUp()
  std::optional<Eigen::Isometry3d> T_a_b;  ///< The pose, if it is known; the reasons name it
  /** Returns Evaluation::rival_same_side. It is called if the match is not sure; empty: 1. */
  std::function<double()> same_side = {};
};

/** Computes the verdict from eqs. (23)-(25) on the pairs of a match, and from evidence that these
 * equations ignore. A wrong pose can lay floors on floors, but it puts walls into the other map's
 * free space.
 * \param[in] a,b The maps A and B.
 * \param[in] pairs Pairs at T_a_b of params.voxels voxels of B, gated as in registration.
 * \param[in] T_a_b Pose of map B in A's frame.
 * \param[in] params Conditions of an accepted match.
 * \param[in] rival The best other pose.
 * \param[in] deviation Standard deviations of the pose. They are large if the match can slide, for
 * example along a corridor without features.
 * \param[in] size_ratio Measured size of B over the size of A. */
Evaluation evaluateMatch(const MapVoxels& a, const MapVoxels& b, const Pairs& pairs,
                         const Eigen::Isometry3d& T_a_b, const EvaluationParams& params,
                         const Rival& rival = {}, const PoseDeviation& deviation = {},
                         const SizeRatio& size_ratio = {});

/** Computes the verdict on a match by evaluateMatch(), from the pairs, rivals and covariance of the
 * match. It neither searches nor changes the match. */
Evaluation judge(const MapFeatures& a, const MapFeatures& b, const MatchResult& match,
                 const EvaluationParams& params);

}  // namespace mrpt::fusion
