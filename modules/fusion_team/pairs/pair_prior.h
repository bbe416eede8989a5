// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>

/** \file
 * What is known of the poses of two maps of a team before their match. */

namespace mrpt::fusion {

/** Returns the prior of a map's pose in the frame of another map. */
Prior priorOf(const RobotMap& map, const RobotMap& in);

}  // namespace mrpt::fusion
