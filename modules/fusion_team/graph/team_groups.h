// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "fusion_team/graph/joint_verdict.h"

/** \file
 * Divides a team into the maps that hold together with the first map, and other groups. */

namespace mrpt::fusion {

/** The maps of a team, placed. */
struct PlacedGroups {
  std::vector<PlacedMap> maps;  ///< Placed are the maps that hold together with map 0
  /** For each map that is not placed: the maps with which it holds together. */
  std::vector<std::vector<size_t>> others;
};

/** Returns further ways between maps that meet in a configuration. */
using FurtherWays = std::function<std::vector<JudgedWay>(const Configuration&)>;

/** Searches the best configuration of a team and judges it. A map that neither a loop nor a sure
 * match connects with the first map may be of another place, and may then spoil the places of
 * others. Of such maps those that contribute least are left out, and the search is repeated.
 * The maps that are not placed are searched for other groups in the same way.
 * \param[in] ways Hypotheses of all pairs.
 * \param[in] evidence Evidence of all pairs.
 * \param[in] names Names of the maps.
 * \param[in] params Settings.
 * \param[in] further Gives further ways after the first search, if there are any. */
PlacedGroups placeGroups(std::vector<JudgedWay> ways, const TeamEvidence& evidence,
                         const std::vector<std::string>& names, const JointVerdictParams& params,
                         const FurtherWays& further = {});

}  // namespace mrpt::fusion
