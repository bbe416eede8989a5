// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/options.h>

#include "fusion_core/features/features.h"

/** \file
 * A second look at a match that is accepted, but not surely. */

namespace mrpt::fusion {

/** The verdict on a match, after a search for a better pose where that is called for.
 *
 * A search around a guess does not see what lies beyond its reach, and a guess may be wrong. A
 * match that judge() accepts with less than EvaluationParams::sure_probability is compared with the
 * best pose of a search from everywhere() (not in the paper). If the maps agree clearly better
 * there, by EvaluationParams::max_runner_up, that pose becomes result.hypotheses[1], and the match
 * is rejected. Such a comparison costs as much as matchMaps() without a guess. \param[in] a,b
 * Features of the maps A and B. \param[in] options As for matchMaps(); options.search is the search
 * that found the match. \param[in,out] result Of matchMaps() or matchAt(). */
Evaluation verify(const MapFeatures& a, const MapFeatures& b, const Options& options,
                  MatchResult& result);

}  // namespace mrpt::fusion
