// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "fusion_octree/slice.h"

/** \file
 * Slices of maps as the files of ROS' map servers (map_server, nav2_map_server). */

namespace mrpt::fusion {

/** Returns a slice as a grey picture, `.pgm` (P5). The first row is the row of the highest y.
 * Occupied cells are black (0), free cells nearly white (254), unknown cells grey (205). */
std::string toPgm(const MapSlice& slice, const CellThresholds& thresholds);

/** Returns the description of a picture of toPgm(), `.yaml`: size, place and thresholds. With these
 * thresholds (occupied 0.65, free 0.196) a map server reads back the three kinds of cells. With
 * nav2's default for free (0.25) it would read unknown cells as free.
 * \param[in] image Name of the picture, relative to the folder of the description. */
std::string toMapYaml(const MapSlice& slice, const std::string& image);

}  // namespace mrpt::fusion
