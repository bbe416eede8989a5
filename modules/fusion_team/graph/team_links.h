// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>

#include <vector>

#include "fusion_team/graph/joint_verdict.h"
#include "fusion_team/pairs/pair_matches.h"

/** \file
 * The matches that hold the placed maps of a team together. */

namespace mrpt::fusion {

/** Adds the links of all placed maps to the members. The link of a map with its parent is the
 * alignment of the member. Any other link is the hypothesis of the match that agrees with the
 * placed poses; a hypothesis without a covariance is registered first.
 * Cost: one registration for each hypothesis without a covariance.
 * \param[in] maps The maps of the team.
 * \param[in] options Parameters of all stages.
 * \param[in] placed The verdict on each map.
 * \param[in] matches The matches of all pairs.
 * \param[in] evidence Evidence of all pairs.
 * \param[in] executor Where registrations run.
 * \param[in,out] memory Registrations of earlier fusions.
 * \param[in,out] members The results, with the alignments of the placed maps. */
void addLinks(const std::vector<RobotMap>& maps, const Options& options,
              const std::vector<PlacedMap>& placed, const std::vector<PairMatch>& matches,
              const TeamEvidence& evidence, Executor& executor, PairMemory& memory,
              std::vector<FusionMember>& members);

}  // namespace mrpt::fusion
