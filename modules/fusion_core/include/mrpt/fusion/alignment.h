// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/options.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPose3DPDFSOG.h>
#include <octomap/OcTree.h>

#include "fusion_core/pair/matching.h"

/** \file
 * All steps from two maps to a pose and a verdict. */

namespace mrpt::fusion {

/** A map to match: an octree, or structural edges alone. One of the two; not owned. */
struct MapView {
  const octomap::OcTree* octree = nullptr;  ///< all that the map knows
  const EdgeVoxels* edges = nullptr;        ///< all that is known of it

  /** \exception std::exception If it is edges alone: they are not judged, nor merged. */
  const octomap::OcTree& wholeMap() const;
};

/** The pose of map m2 (the scene, "B") in the frame of map m1 (the model, "A"), and what was found
 * out on the way. */
struct Alignment {
  /** The covariance is that of (x, y, z, yaw, pitch, roll), from the final Hessian, or from that at
   * a pose that was given. */
  mrpt::poses::CPose3DPDFGaussian pose;
  bool by_edges = false;     ///< a map is edges alone: edges alone were compared
  unsigned nIterations = 0;  ///< of both levels
  MatchResult match;         ///< pose, covariance, iterations with their MSE, pairs
  Evaluation evaluation;     ///< the verdict and its reasons
  size_t edges_m1 = 0;       ///< edge voxels of m1
  size_t edges_m2 = 0;       ///< edge voxels of m2
  size_t voxels_m1 = 0;      ///< occupied voxels of m1
  size_t voxels_m2 = 0;      ///< occupied voxels of m2
  /** The distinct poses that were compared, best first, one mode each with its covariance; their
   * log-weights are of how well the maps agree there. Empty without a search. */
  mrpt::poses::CPose3DPDFSOG hypotheses{0};
  double seconds_features = 0;    ///< wall time of what is computed once per map, s
  double seconds_matching = 0;    ///< wall time of search and both levels, s
  double seconds_evaluation = 0;  ///< wall time of the verdict, s
};

/** Two-level probabilistic map matching, and whether its result can be trusted: computeFeatures(),
 * matchMaps(), judgeMatch(). If either map is edges alone, the edges of both are compared, and free
 * space where it is known: that tells where the maps meet, and is never accepted.
 * \param[in] m1,m2 The maps A and B. \param[in] prior Its mean is the initial guess, its covariance
 * bounds the search, see searchWithin(). \param[in] options All but merge. \param[in] on_iteration
 * Called after each iteration, if given.
 * \exception std::exception If the guess is no pose, or a map has no occupied (edge) voxel. */
Alignment align(const MapView& m1, const MapView& m2, const mrpt::poses::CPose3DPDFGaussian& prior,
                const Options& options, const OnIteration& on_iteration = {});

/** Judges a given pose of m2 in m1. The result's match has the pairs at that pose.
 * \exception std::exception If a map is edges alone. */
Alignment evaluate(const MapView& m1, const MapView& m2, const mrpt::poses::CPose3D& pose,
                   const Options& options);

}  // namespace mrpt::fusion
