// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "fusion_team/graph/team_graph.h"

/** \file
 * The best configuration of a team, and its rivals. */

namespace mrpt::fusion {

/** The best configuration of a team, and how clear it is. */
struct TeamSearchResult {
  Configuration best;                 ///< The configuration with the largest score
  std::vector<Configuration> others;  ///< Other configurations that were found, best score first
  size_t first = 0;                   ///< Map in whose frame the configurations are compared
  /** For each placed map: the best rival that places it elsewhere in the frame of the first map.
   * The value is the score that connects the rival's groups of maps over the score that connects
   * the same groups in the best configuration. 0 without a rival; above 1 if a rival is better. */
  std::vector<double> runner_up;
};

/** Searches the best configuration: grows configurations from the best ways, improves all that
 * differ by moves of one map, the best of them by what other configurations do better, see
 * crossed(), and by moves of two maps. Compares the result with all others and with other places of
 * blocks of maps, see otherPlaces().
 *
 * \param[in] ways Hypotheses of all pairs. Maps without a hypothesis are not placed.
 * \param[in] evidence Evidence of all pairs.
 * \param[in] most_starts Number of ways from which configurations grow. Maps that are in none of
 * these configurations are starts, too.
 * \param[in] first Map in whose frame the configurations are compared. */
TeamSearchResult searchTeam(const std::vector<Way>& ways, const TeamEvidence& evidence,
                            size_t most_starts, size_t first = 0);

/** Searches the best configuration with other ways, from the configurations of a search before.
 * \param[in] before Result of the search before.
 * \param[in] ways Hypotheses of the pairs of all maps that stay.
 * \param[in] evidence Evidence of all pairs.
 * \param[in] left_out Maps that do not stay. */
TeamSearchResult searchAgain(const TeamSearchResult& before, const std::vector<Way>& ways,
                             const TeamEvidence& evidence,
                             const std::vector<size_t>& left_out = {});

}  // namespace mrpt::fusion
