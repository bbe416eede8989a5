// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion info`. */

#include <string>
#include <vector>

#include "commands/commands.h"
#include "fusion_base/file_names.h"
#include "inputs.h"

namespace map_fusion {

bool runInfo(RunContext& run) {
  const auto& paths = run.args.maps;
  const auto names =
      paths.size() > 1 ? mrpt::fusion::namesOf(paths) : std::vector<std::string>{"map"};
  for (size_t i = 0; i < paths.size(); i++) loadFileOfRobots(run, names[i], paths[i]);
  run.endStep("load");
  return true;
}

}  // namespace map_fusion
