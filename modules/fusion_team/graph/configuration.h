// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "fusion_team/graph/scored_team.h"

/** \file
 * Searches the poses of a team at which all pairs of maps agree best. */

namespace mrpt::fusion {

/** Areas of the surfaces of a team's maps, m^2. A surface that many maps see counts once. */
struct TeamAreas {
  double confirmed = 0;     ///< Area that at least one other map confirms
  double displaced = 0;     ///< Area in the free space of another map, near its obstacles
  double contradicted = 0;  ///< Area in the free space of another map, away from its obstacles
  double explained = 0;     ///< Area in the free space of another map, where a sure match places it

  double conflictRatio() const {
    const double conflicts = displaced + contradicted + explained, known = confirmed + conflicts;
    return known > 0 ? conflicts / known : 0;
  }
};
/** Returns the areas of map \a k, compared with all other placed maps, and of the other maps,
 * each compared with map \a k: conflicts show in both directions. */
TeamAreas areasOf(size_t k, const ScoredTeam& team);
/** Returns the score of a configuration, see ScoredTeam::configuration(). Repeated rooms
 * let many maps lie on one another; a sum over pairs would prefer that pile, because it counts each
 * surface as often as maps see it. */
double scoreOf(const Configuration& c, const TeamEvidence& evidence);

/** Returns the poses of some maps of a configuration, with their score. */
Configuration with(const Configuration& c, const std::vector<size_t>& maps,
                   const TeamEvidence& evidence);
/** Returns the poses of all maps of a configuration but some, with their score. */
Configuration without(const Configuration& c, const std::vector<size_t>& maps,
                      const TeamEvidence& evidence);

/** Returns the configuration of the two maps of a way, in the frame of map A. */
Configuration pairOf(const Way& way, const TeamEvidence& evidence);

/** Which map is placed next. */
enum class GrowthOrder {
  LargestGain,  ///< The map whose place gains most
  Clearest      ///< The map whose place gains most more than its second best place
};

/** Grows a configuration from a pair: places maps one after another while the score grows. All
 * pairs have a say, also pairs that were never matched. */
Configuration grownFrom(const Way& seed, const TeamWays& ways, const TeamEvidence& evidence,
                        GrowthOrder order);

/** Optimises the poses of a configuration: the errors of long chains of pairs spread over all
 * pairs. Keeps the poses if the score does not grow. */
void settle(Configuration& configuration, const TeamEvidence& evidence);

/** Which maps move at once. */
enum class Moves {
  OfOneMap,  ///< Each map alone
  /** Each map alone, and each two maps with a hypothesis of their pair or that meet each other. */
  OfOneOrTwo
};

/** Improves a configuration by moves: places a map elsewhere, places a missing map, takes a map
 * out. Ends when no move increases the score. A move is tried again only after a change of maps
 * that meet its maps or have hypotheses with them. */
void improve(Configuration& configuration, const TeamWays& ways, const TeamEvidence& evidence,
             Moves moves);

}  // namespace mrpt::fusion
