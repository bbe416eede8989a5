// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "fusion_team/graph/configuration.h"
#include "fusion_team/graph/place_model.h"
#include "fusion_team/graph/team_search.h"

/** \file
 * The verdict of a team: which maps are placed right. */

namespace mrpt::fusion {

/** A way of a match, with the verdict on the pair alone. */
struct JudgedWay {
  Way way;
  double probability = 0;  ///< Probability of the pair's verdict; 0 for rivals of the match
};

/** Settings of the verdict of a team. */
struct JointVerdictParams {
  /** Largest gain of another place over the gain of the place, see TeamSearchResult::runner_up. */
  double max_runner_up = 0.8;
  double max_conflict = 0.10;  ///< Largest share of a map's surface in free space
  /** Largest probability that a wrong pair without a loop is accepted, for all pairs of a map
   * together. */
  double max_risk = 0.15;
  PlaceModel model;  ///< Probability of a place

  /** Least probability of the place of a placed map. */
  double leastProbability() const { return 1 - max_risk; }

  /** Least probability of a match of one pair that is sure without a loop, in a team of \a n maps.
   */
  double leastSureProbability(size_t n) const {
    return 1 - max_risk / static_cast<double>(n > 2 ? n - 1 : 1);
  }
};

/** The verdict on one map of a team. */
struct PlacedMap {
  bool placed = false;     ///< True if the pose can be trusted
  bool confirmed = false;  ///< True if loops or sure matches connect it with the first map
  std::optional<Eigen::Isometry3d> pose;  ///< Pose in the frame of the first map, if searched
  std::optional<size_t> parent;           ///< Map of the strongest way in, on the way to the first
  std::vector<size_t> ways_in;            ///< Maps whose own matches give this place
  double runner_up = 0;                   ///< See TeamSearchResult::runner_up
  TeamAreas areas;                        ///< Evidence of all other placed maps
  double overlap = 0;                     ///< See overlapsWith()
  double probability = 0;                 ///< Probability that the pose is right; 0 without a pose
  std::vector<std::string> reasons;       ///< Reasons of the verdict, one sentence each
};

/** Returns the reasons of a map that is shown at its best match and not at its place, if it has
 * one. \param[in] partner Name of the map that it is matched with. */
std::vector<std::string> reasonsAtMatch(const PlacedMap& map, const std::string& partner);

/** Returns the names of maps, separated by commas. */
std::string listOf(const std::vector<size_t>& maps, const std::vector<std::string>& names);

/** Returns for each map how far it overlaps with the first map, directly or by other maps, [0,1].
 * The overlap of two maps is the share of the surface of one of them that the other confirms, the
 * larger share of both. The overlap of a chain of maps is that of its weakest pair. The result is
 * that of the best chain to each map; 0 for maps without a pose. So two strangers that overlap each
 * other are not taken to overlap the team. Cost: O(n^2). */
std::vector<double> overlapsWith(size_t first, const Configuration& c,
                                 const TeamEvidence& evidence);

/** Judges the best configuration of a team. A map is placed if
 * - no other place of the map gains nearly as much, and few of its obstacles lie in free space;
 * - the place is right with a probability of at least 1 - max_risk, see PlaceModel;
 * - a loop of matches connects it with the first map, or a match that is sure without a loop. The
 *   match of one pair is sure if its probability of being wrong is at most max_risk over the
 *   number of pairs that were tried for a map: many pairs have many chances to be wrong. A map
 *   whose own place is not clear may close the loop of other maps.
 * \param[in] result The configuration; its poses are in any frame.
 * \param[in] ways Hypotheses of all pairs.
 * \param[in] evidence Evidence of all pairs.
 * \param[in] names Names of the maps.
 * \param[in] params Settings. */
std::vector<PlacedMap> judgeTeam(const TeamSearchResult& result, const std::vector<JudgedWay>& ways,
                                 const TeamEvidence& evidence,
                                 const std::vector<std::string>& names,
                                 const JointVerdictParams& params);

}  // namespace mrpt::fusion
