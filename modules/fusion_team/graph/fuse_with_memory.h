// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>

#include <vector>

#include "fusion_team/graph/team_memory.h"

/** \file
 * Fuses maps with the results of earlier fusions. */

namespace mrpt::fusion {

/** Fuses maps, see fuseMaps(). The result is the same, bit for bit, with any memory of fusions with
 * the same options.
 * \param[in] maps,options,even_rejected,on_member,on_iteration See fuseMaps().
 * \param[in,out] memory Results of earlier fusions; gets the results of this fusion. */
TeamState fuseWithMemory(const std::vector<RobotMap>& maps, const Options& options,
                         TeamMemory& memory, bool even_rejected = false,
                         const OnMember& on_member = {}, const OnIteration& on_iteration = {});

}  // namespace mrpt::fusion
