// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/fusion/map_files.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <string>
#include <utility>
#include <vector>

#include "support/mrpt_tools.h"
#include "support/observations.h"

/** \file
 * Recordings that tests make. */

namespace map_tests {

using Objects = std::vector<mrpt::serialization::CSerializable::Ptr>;

inline mrpt::obs::CObservation::Ptr stamped(const mrpt::obs::CObservation::Ptr& obs,
                                            double seconds) {
  obs->timestamp = mrpt::Clock::fromDouble(1.6e9 + seconds);
  return obs;
}

inline mrpt::obs::CObservation::Ptr unstamped(const mrpt::obs::CObservation::Ptr& obs) {
  obs->timestamp = INVALID_TIMESTAMP;
  return obs;
}

inline mrpt::poses::CPose3D placeAt(double seconds) {
  return {0.7 * seconds, -0.3 * seconds, 0.1, 0.2 * seconds, 0.05, 0};
}

/** Returns the pose of the robot at a time. */
inline mrpt::obs::CObservation::Ptr robotPoseAt(double seconds) {
  auto obs = mrpt::obs::CObservationRobotPose::Create();
  obs->pose.mean = placeAt(seconds);
  return stamped(obs, seconds);
}

inline mrpt::obs::CObservation::Ptr cloudAt(double seconds) {
  constexpr size_t kPoints = 100;
  return stamped(cloudOf(domePoints(10 + static_cast<unsigned>(seconds), kPoints)), seconds);
}

inline std::string bytesOf(const Objects& objects) {
  std::string bytes;
  for (const auto& o : objects) bytes += serialized(*o);
  return bytes;
}

/** Returns a map of the clouds at times, each at the pose of the robot at its time. */
inline mrpt::maps::CProbOctoMap mapOfClouds(const std::vector<double>& seconds) {
  mrpt::maps::CProbOctoMap map;
  for (const double s : seconds) map.insertObservation(*cloudAt(s), placeAt(s));
  return map;
}

inline bool isSameMap(const mrpt::maps::CProbOctoMap& expected,
                      const mrpt::fusion::BuiltMap& built) {
  const auto map = std::dynamic_pointer_cast<mrpt::maps::CProbOctoMap>(built.map);
  return map && sameTree(expected.octree(), map->octree());
}

}  // namespace map_tests
