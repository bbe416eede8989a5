// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion info`. */

#include "commands/commands.h"
#include "inputs.h"

namespace map_fusion {

bool runInfo(RunContext& run) {
  const std::string& path = run.args.maps[0];
  const auto robots = loadMission(run, path);
  for (const auto& robot : robots) {
    run.report.maps.push_back(mrpt::fusion::reportOn(robot.name, path, *robot.map.octree));
    run.report.maps.back().sources = robot.map.sources;
  }
  if (robots.empty()) loadMap(run, "map", path);
  run.endStep("load");
  return true;
}

}  // namespace map_fusion
