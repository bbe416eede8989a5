// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/prepared_map.h>
#include <mrpt/maps/CMetricMap.h>

/** \file
 * Prepares maps for the duration of a call. */

namespace mrpt::fusion {

/** Prepares a map without a copy, see prepare(). The result refers to the octree of \a map, so \a
 * map must outlive it. */
PreparedMap prepareBorrowed(const mrpt::maps::CMetricMap& map, const FeatureParams& params);

}  // namespace mrpt::fusion
