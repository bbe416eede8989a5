// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/options.h>
#include <mrpt/fusion/poses.h>

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

/** Judges a match near a guess, and searches farther while the match is not sure. A match is sure
 * if it is accepted with a probability of at least EvaluationParams::sure_probability.
 *
 * A guess may be wrong, and a search near a guess starts from few hypotheses. A clearly better pose
 * of a wider search (EvaluationParams::max_runner_up) replaces the match if judge() accepts the
 * better pose, or if both poses are rejected and the better pose is more probable. The match then
 * stays as a rival. In all other cases the clearly better pose becomes the rival of the match, and
 * the match is rejected.
 * A prior with a covariance bounds all searches: a rival outside does not overrule the match.
 * Cost: each search costs as much as matchMaps() without a guess.
 * \param[in] a,b Features of the maps A and B.
 * \param[in] prior The guess.
 * \param[in] options As for matchMaps(); options.search is the search that found the match.
 * \param[in,out] result Result of matchMaps(). */
Evaluation judgeAndSearchWider(const MapFeatures& a, const MapFeatures& b, const Prior& prior,
                               const Options& options, MatchResult& result);

}  // namespace mrpt::fusion
