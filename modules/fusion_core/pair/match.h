// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/options.h>

#include <Eigen/Geometry>

#include "fusion_core/features/features.h"
#include "fusion_core/verdict/hypotheses.h"

/** \file
 * The match of two prepared maps: search, ranking and registration. */

namespace mrpt::fusion {

/** Estimates the pose of map B in A's frame from several starts. It is not in the paper, whose
 * optimiser starts at the guess.
 *
 * The starts are the guess after the edge level, and the best poses of searchAround(). Each start
 * is refined with some voxels; if the starts are many, first with fewer voxels. The pose with the
 * best agreement() goes through the voxel level. If the voxel level moves far from it, the final
 * pose is compared with the other hypotheses as well, see registerRivals().
 *
 * Without a search (options.search.translation = 0) this function is matchTwoLevel().
 * \param[in] a,b Features of the maps A and B.
 * \param[in] T_a_b The guess.
 * \param[in] options Parameters; `features` and `merge` are not used.
 * \param[in] on_iteration See matchTwoLevel(). */
MatchResult matchMaps(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                      const Options& options, const OnIteration& on_iteration = {});

/** Registers rivals of a match with all voxels, as long as a rival agrees better than what the
 * registration has reached. The result is the reached pose that agrees best. A match that agrees
 * better than its rivals stays as it is.
 * \param[in] a,b Features of the maps A and B.
 * \param[in] association See associationOf().
 * \param[in] began Pose from which the registration of the match began.
 * \param[in] options Parameters of the match; `ranking.max_rivals` limits the registrations.
 * \param[in,out] result The match after compareWhatWasReached().
 * \param[in] on_iteration See matchTwoLevel(). */
void registerRivals(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                    const Eigen::Isometry3d& began, const Options& options, MatchResult& result,
                    const OnIteration& on_iteration = {});

/** Returns the match at a given pose: its pairs and its covariance. */
MatchResult matchAt(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                    const Options& options);

/** Registers the maps with all voxels from a pose, without a search. The pose moves by at most the
 * tolerance of a right pose; a registration that moves it farther is not used. */
MatchResult matchFrom(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                      const Options& options);

/** Returns the agreement of the best pose that a coarse search with few voxels finds, see
 * agreement(). It tells which of many pairs of maps are worth a match, at a tenth of its cost.
 * \param[in] a,b Features of the maps A and B.
 * \param[in] T_a_b The guess, for a search around it.
 * \param[in] options Parameters of a match. */
double coarseAgreement(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                       Options options);

/** Returns the settings of a comparison of hypotheses from the options. */
ComparisonParams comparisonOf(const Options& options);

}  // namespace mrpt::fusion
