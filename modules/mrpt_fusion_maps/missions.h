// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservationLocalMap.h>

#include <string>
#include <vector>

/** \file
 * Recorded missions: rawlogs with the maps of several robots. */

namespace mrpt::fusion {

/** Reads the latest map of each robot from a rawlog. \exception std::runtime_error As
 * loadLocalMaps(), without the path. */
std::vector<mrpt::obs::CObservationLocalMap::Ptr> latestMaps(const std::string& path);

}  // namespace mrpt::fusion
