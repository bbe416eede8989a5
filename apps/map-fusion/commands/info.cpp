// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion info`. */

#include "commands/commands.h"
#include "inputs.h"

namespace map_fusion {

bool runInfo(RunContext& run) {
  loadFileOfRobots(run, "map", run.args.maps[0]);
  run.endStep("load");
  return true;
}

}  // namespace map_fusion
