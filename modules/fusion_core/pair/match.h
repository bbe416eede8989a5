// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/options.h>

#include <Eigen/Geometry>

#include "fusion_core/features/features.h"
#include "fusion_core/verdict/hypotheses.h"

/** \file
 * The conductor of a pair: search, registration and ranking of two prepared maps. */

namespace mrpt::fusion {

/** Finds the pose of map B in A's frame, from several starts (not in the paper, whose optimiser
 * starts at the guess): the guess carried through the edge level, and the best poses that
 * searchAround() finds near it. Each is refined on a few voxels, many of them on fewer first. The
 * pose where the maps then agree best, see agreement(), goes through the voxel level. Where that
 * leads to another pose, the other pose is compared with the rest as well.
 * Without a search (options.search.translation = 0) it is matchTwoLevel().
 * \param[in] a,b Features of the maps A and B. \param[in] T_a_b The guess. \param[in] options All
 * but merge. \param[in] on_iteration See matchTwoLevel(). */
MatchResult matchMaps(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                      const Options& options, const OnIteration& on_iteration = {});

/** A match at a pose that is given: its pairs and its covariance there. */
MatchResult matchAt(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                    const Options& options);

/** What a comparison of hypotheses takes from the options. */
ComparisonParams comparisonOf(const Options& options);

}  // namespace mrpt::fusion
