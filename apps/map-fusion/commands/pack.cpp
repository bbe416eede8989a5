// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion pack`. */

#include <filesystem>

#include "commands/commands.h"
#include "inputs.h"
#include "mrpt_maps.h"

namespace map_fusion {

bool runPack(RunContext& run) {
  const auto robots = loadRobots(run);
  mrptMaps().saveMission(robots, run.args.smallest, run.args.output);
  run.wrote(run.args.output);
  run.endStep("save");
  if (std::filesystem::is_regular_file(run.args.output))  // a pipe has no size
    run.report.bytes = std::filesystem::file_size(run.args.output);
  return true;
}

}  // namespace map_fusion
