// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "fusion_team/graph/configuration.h"

/** \file
 * Other places of blocks of maps: maps that keep their shape while they move. */

namespace mrpt::fusion {

/** Returns blocks of the placed maps of a configuration that may be misplaced together: each map,
 * and what is left in one piece if one or two links are cut from the tree of the strongest links.
 * Of a large team these are the blocks with the weakest links, 4 for each map. A block has at most
 * half of the maps: the other half moves the other way. */
std::vector<std::vector<size_t>> blocksOf(const Configuration& c, const TeamEvidence& evidence);

/** Returns the configurations in which one block of maps is elsewhere and gains from the other
 * maps. Ways between the block and the other maps give the places. */
std::vector<Configuration> otherPlaces(const Configuration& c, const TeamWays& ways,
                                       const TeamEvidence& evidence);

/** Returns the configurations in which a rigid group of two configurations, see rigidGroups(), lies
 * to another group as the second configuration says, and all other maps lie as in the first, if the
 * group gains there. Each configuration may join its groups wrongly at places where another
 * configuration joins them right. */
std::vector<Configuration> crossed(const Configuration& c, const Configuration& other,
                                   const TeamEvidence& evidence);

}  // namespace mrpt::fusion
