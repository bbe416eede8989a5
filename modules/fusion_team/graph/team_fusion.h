// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>

#include <vector>

#include "fusion_team/graph/joint_verdict.h"
#include "fusion_team/pairs/pair_matches.h"

/** \file
 * Places the maps of a team. */

namespace mrpt::fusion {

/** The maps of a team at their places. */
struct PlacedTeam {
  std::vector<FusionMember> members;  ///< Result of each map, in the order of the input
  std::vector<TeamPair> pairs;        ///< Matches of the pairs
  std::vector<PlacedMap> places;      ///< Verdict on each map
};

/** Places whole maps by all their pairs together. A map without a place that can be trusted has
 * joined = false, and its best match with a placed map. The first map has the identity.
 * Cost: n (n-1) / 2 matches, at most 12 n, and a search of the configuration.
 * \param[in] maps Two or more whole maps.
 * \param[in] options Parameters of all stages.
 * \param[in] on_member See fuseMaps().
 * \param[in,out] memory Results of earlier fusions with the same options. */
PlacedTeam placeTeam(const std::vector<RobotMap>& maps, const Options& options,
                     const OnMember& on_member, PairMemory& memory);

/** Places whole maps by given matches of their pairs, see placeTeam(). Then matches other pairs
 * that meet at these places, up to kMatchesPerMap matches for each map in all.
 *
 * \param[in] maps Two or more whole maps.
 * \param[in] matches Matches of the pairs. Each map has a match with the first map or a map that is
 * matched with it.
 * \param[in] options Parameters of all stages.
 * \param[in,out] memory Results of earlier fusions with the same options. */
PlacedTeam placeByMatches(const std::vector<RobotMap>& maps, std::vector<PairMatch> matches,
                          const Options& options, PairMemory& memory);

}  // namespace mrpt::fusion
