// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "fusion_team/graph/team_graph.h"

/** \file
 * Groups of maps that lie alike in two configurations. */

namespace mrpt::fusion {

/** Divides the maps that two configurations place into rigid groups: within a group both
 * configurations have the same poses. The largest group comes first. */
std::vector<std::vector<size_t>> rigidGroups(const Configuration& c, const Configuration& other,
                                             const TeamEvidence& evidence);

}  // namespace mrpt::fusion
