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

/** The pose of map B in the frame of map A, the verdict, and the records of both. */
struct MRPT_FUSION_API Alignment {
  MatchResult match;              ///< Pose, covariance, hypotheses, iterations, pairs
  Evaluation evaluation;          ///< The verdict and its reasons
  bool by_edges = false;          ///< True if only edges were compared: a map has only edges
  double scale = 1;               ///< Factor of all lengths in the options, see ScaleParams
  size_t edges_a = 0;             ///< Number of edge voxels of A
  size_t edges_b = 0;             ///< Number of edge voxels of B
  size_t voxels_a = 0;            ///< Number of occupied voxels of A
  size_t voxels_b = 0;            ///< Number of occupied voxels of B; 0: no match was made
  double seconds_matching = 0;    ///< Wall time of search, ranking and both levels, s
  double seconds_evaluation = 0;  ///< Wall time of the verdict, s

  /** Converts the pose of match to MRPT's Gaussian of (x, y, z, yaw, pitch, roll). */
  mrpt::poses::CPose3DPDFGaussian pose() const;
  /** Converts the hypotheses of match to MRPT's sum of Gaussians, best pose first. Each pose is a
   * mode; its log-weight is the logarithm of its agreement. Empty without a search. */
  mrpt::poses::CPose3DPDFSOG hypotheses() const;
};

/** Estimates the pose of B in A by two-level probabilistic map matching, and judges the result:
 * matchMaps(), then judgeAndSearchWider().
 *
 * If a map has only edges, the edges of both maps are compared, and free space where it is known.
 * The result shows where the maps meet. It is never accepted.
 * The result does not depend on the number of threads.
 * \param[in] a,b The maps A and B.
 * \param[in] prior Knowledge of B's pose in A's frame.
 * \param[in] options Parameters; `features` and `merge` are not used.
 * \param[in] on_iteration Called after each iteration, if given; never by two threads at a time.
 * \exception std::exception If the guess is not finite or farther away than maps can reach, if a
 * map has no occupied (edge) voxel, or if one voxel size is more than 1000 times the other. */
MRPT_FUSION_API Alignment align(const PreparedMap& a, const PreparedMap& b, const Prior& prior,
                                const Options& options, const OnIteration& on_iteration = {});

/** Judges a given pose of B in A. The match of the result holds the pairs at that pose.
 * \exception std::exception If a map has only edges. */
MRPT_FUSION_API Alignment evaluate(const PreparedMap& a, const PreparedMap& b,
                                   const mrpt::poses::CPose3D& pose, const Options& options);

}  // namespace mrpt::fusion
