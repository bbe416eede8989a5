// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/export.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/options.h>
#include <mrpt/fusion/poses.h>
#include <mrpt/fusion/prepared_map.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPose3DPDFSOG.h>

#include <cstddef>

/** \file
 * All steps from two maps to a pose and a verdict. */

namespace mrpt::fusion {

/** The pose of map B in the frame of map A, the verdict, and what was found out on the way. */
struct MRPT_FUSION_API Alignment {
  MatchResult match;              ///< Pose, covariance, hypotheses, iterations, pairs
  Evaluation evaluation;          ///< The verdict and its reasons
  bool by_edges = false;          ///< True if edges alone were compared, as a map is edges alone
  size_t edges_a = 0;             ///< Edge voxels of A
  size_t edges_b = 0;             ///< Edge voxels of B
  size_t voxels_a = 0;            ///< Occupied voxels of A
  size_t voxels_b = 0;            ///< Occupied voxels of B; 0: nothing was matched
  double seconds_matching = 0;    ///< Wall time of search, ranking and both levels, s
  double seconds_evaluation = 0;  ///< Wall time of the verdict, s

  /** The pose as MRPT's Gaussian of (x, y, z, yaw, pitch, roll); made of match. */
  mrpt::poses::CPose3DPDFGaussian pose() const;
  /** The distinct poses that were compared, best first, as MRPT's sum of Gaussians: a mode each,
   * with the logarithm of its agreement as log-weight; made of match. Empty without a search. */
  mrpt::poses::CPose3DPDFSOG hypotheses() const;
};

/** Two-level probabilistic map matching, and whether its result can be trusted: matchMaps(), then
 * verify(). If either map is edges alone, the edges of both are compared, and free space where it
 * is known: that tells where the maps meet, and is never accepted. Deterministic, whatever the
 * number of threads. \param[in] a,b The maps A and B. \param[in] prior What is known of B's pose in
 * A's frame. \param[in] options All but features and merge. \param[in] on_iteration Called after
 * each iteration, if given; never by two threads at a time. \exception std::exception If the guess
 * is no pose or is farther away than the maps can reach, a map has no occupied (edge) voxel, or the
 * voxels of one map are more than 1000 times as wide as those of the other. */
MRPT_FUSION_API Alignment align(const PreparedMap& a, const PreparedMap& b, const Prior& prior,
                                const Options& options, const OnIteration& on_iteration = {});

/** Judges a given pose of B in A. The result's match has the pairs at that pose.
 * \exception std::exception If a map is edges alone, or the pose or the voxel sizes are such as
 * align() refuses. */
MRPT_FUSION_API Alignment evaluate(const PreparedMap& a, const PreparedMap& b,
                                   const mrpt::poses::CPose3D& pose, const Options& options);

}  // namespace mrpt::fusion
