// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "robot_simulator.h"
#include "world.h"

namespace mrpt::fusion::sim {

/** Several robots with the same kind of lidar and of errors. */
struct Mission {
  Lidar lidar;
  PoseNoise noise;
  std::vector<RobotPlan> robots;
  uint32_t seed = 0;  //!< Robot i draws its errors from seed + i.
};

/** Reads a mission file; geb079.ini explains its keys. Every key must be there.
 * \exception std::runtime_error One line that names the file, the key and what is wrong with it.
 */
Mission loadMission(const std::string& path);

/** Runs all robots of the mission, in its order. */
std::vector<Recording> runMission(const World& world, const Mission& mission);

}  // namespace mrpt::fusion::sim
