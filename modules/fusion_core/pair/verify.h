// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/options.h>

#include "fusion_core/features/features.h"

/** \file
 * The check of a given pose. */

namespace mrpt::fusion {

/** Returns the verdict on a given pose. Searches for a better pose if the verdict needs it.
 *
 * A given pose may be wrong. If its probability is below EvaluationParams::sure_probability, the
 * pose is compared with the best pose of a search without bounds, see everywhere() (not in the
 * paper). If the agreement of the given pose is at most EvaluationParams::max_runner_up times the
 * agreement of the best pose, the best pose becomes result.hypotheses[1], and the given pose is
 * rejected; the reasons name the best pose. Cost of the comparison: matchMaps() without
 * a guess.
 * \param[in] a,b Features of the maps A and B.
 * \param[in] options As for matchMaps(). No search or a search without bounds: no comparison.
 * \param[in,out] result Result of matchAt(). */
Evaluation verify(const MapFeatures& a, const MapFeatures& b, const Options& options,
                  MatchResult& result);

}  // namespace mrpt::fusion
