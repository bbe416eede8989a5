// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservationLocalMap.h>

#include <vector>

/** \file
 * Recorded missions: rawlogs with the maps of several robots. */

namespace mrpt::fusion {

/** Adds a map of a mission to the latest maps of the robots. The order is that of the first maps of
 * the robots. */
void addToLatest(mrpt::obs::CObservationLocalMap::Ptr map,
                 std::vector<mrpt::obs::CObservationLocalMap::Ptr>& latest);

}  // namespace mrpt::fusion
