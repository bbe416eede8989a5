// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/serialization/CSerializable.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "fusion_link/map_replica.h"

/** \file
 * Recorded missions: rawlogs with the maps of several robots. */

namespace mrpt::fusion {

/** The latest maps of the robots of a mission, as whole maps or by their diffs. */
class LatestMaps {
 public:
  /** Adds an object of a mission, if it is a map or a diff.
   * \exception std::runtime_error If a diff is damaged. */
  void add(const mrpt::serialization::CSerializable::Ptr& object);
  /** Returns the maps, in the order of the first objects of their robots. Diffs become a map with
   * the version as its sequence.
   * \exception std::runtime_error If the diffs of a robot are not all there. */
  std::vector<mrpt::obs::CObservationLocalMap::Ptr> maps() const;
  /** Returns the number of objects that were maps or diffs. */
  size_t count() const { return count_; }

 private:
  struct Robot {
    std::string name;
    mrpt::obs::CObservationLocalMap::Ptr map;  // null: none
    std::optional<MapReplica> diffs;
    mrpt::Clock::time_point last_diff{};
  };
  Robot& robot(const std::string& name);

  std::vector<Robot> robots_;
  size_t count_ = 0;
};

/** Returns the map of a mission of one robot.
 * \exception std::runtime_error If there are several robots, or if the robot has no map. */
mrpt::maps::CMetricMap::Ptr onlyMapOf(
    const std::vector<mrpt::obs::CObservationLocalMap::Ptr>& robots);

}  // namespace mrpt::fusion
