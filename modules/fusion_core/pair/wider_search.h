// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/options.h>
#include <mrpt/fusion/poses.h>

#include <Eigen/Geometry>
#include <vector>

#include "fusion_core/features/features.h"

/** \file
 * The searches that follow an unsure match near a guess (not in the paper). */

namespace mrpt::fusion {

/** Returns the searches to try after the search near a guess, in their order: the same bounds with
 * as many hypotheses as everywhere(), then everywhere() if the prior states no covariance. Empty
 * without a guess, without a search, or if the search is to stay as it is
 * (EvaluationParams::sure_probability is 0).
 * \param[in] prior The guess.
 * \param[in] options options.search is the search near the guess. */
std::vector<SearchParams> widerSearches(const Prior& prior, const Options& options);

/** Returns whether B is tilted against the guess by more than LevellingParams::max_tilt. A search
 * that turns B about the vertical can reach such a pose only by a registration that went astray.
 * Always false if the search tries all rotations. */
bool isTooTilted(const Eigen::Isometry3d& T_a_b, const Eigen::Isometry3d& guess,
                 const SearchParams& search);

/** Judges a match near a guess, and searches farther while the match is not sure. A match is sure
 * if it is accepted with a probability of at least EvaluationParams::sure_probability.
 *
 * A guess may be wrong, and a search near a guess starts from few hypotheses. A clearly better pose
 * of a wider search (EvaluationParams::max_runner_up) replaces the match if judge() accepts the
 * better pose, or if both poses are rejected and the better pose is more probable. The match then
 * stays as a rival. In all other cases the clearly better pose becomes the rival of the match, and
 * the match is rejected.
 * A pose that isTooTilted() is no place of a wider search.
 * A prior with a covariance bounds all searches: a rival outside does not overrule the match.
 * Cost: each search costs as much as matchMaps() without a guess.
 * \param[in] a,b Features of the maps A and B.
 * \param[in] prior The guess.
 * \param[in] options As for matchMaps(); options.search is the search that found the match.
 * \param[in,out] result Result of matchMaps(). */
Evaluation judgeAndSearchWider(const MapFeatures& a, const MapFeatures& b, const Prior& prior,
                               const Options& options, MatchResult& result);

}  // namespace mrpt::fusion
