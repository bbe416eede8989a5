// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/prepared_map.h>
#include <mrpt/maps/CMetricMap.h>

/** \file
 * Maps that are prepared for the time of a call. */

namespace mrpt::fusion {

/** As prepare(), but the result refers to the octree of \a map, which must outlive it. */
PreparedMap prepareBorrowed(const mrpt::maps::CMetricMap& map, const FeatureParams& params);

}  // namespace mrpt::fusion
