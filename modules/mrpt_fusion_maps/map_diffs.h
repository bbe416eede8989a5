// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservationLocalMap.h>

#include "fusion_link/map_diff.h"
#include "fusion_link/map_replica.h"

/** \file
 * Diffs of maps as observations, and what they give. */

namespace mrpt::fusion {

/** Returns a replica without samples for the robot of a diff. */
MapReplica emptyReplicaOf(const mrpt::obs::CObservationMapDiff& diff);

/** Adds a diff to what there is of the map of its robot. A diff with all blocks starts anew, also
 * if its version is lower: the robot may have been restarted.
 * \exception std::runtime_error If the diff is damaged or too large: \a map is as before. */
void addDiff(const mrpt::obs::CObservationMapDiff& diff, MapReplica& map);

/** Returns a diff as an observation of the present time. */
inline mrpt::obs::CObservationMapDiff::Ptr observationOf(const MapDiff& diff) {
  auto observation = mrpt::obs::CObservationMapDiff::Create();
  observation->timestamp = mrpt::Clock::now();
  observation->sensorLabel = nameOf(diff.source);
  observation->version = diff.version;
  observation->index = diff.index;
  for (const auto& block : diff.blocks)
    observation->blocks.push_back({block.code, block.version, *block.bytes});
  return observation;
}

}  // namespace mrpt::fusion
