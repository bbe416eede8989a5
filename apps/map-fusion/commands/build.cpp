// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion build`. */

#include "commands/commands.h"
#include "mrpt_maps.h"

namespace map_fusion {

bool runBuild(RunContext& run) {
  const auto built = mrptMaps().build(run.args.maps[0], run.mapDefinition());
  run.progress.clear();
  run.endStep("build");
  mrptMaps().save(built.map, run.args.output);
  run.endStep("save");
  run.report.observations = {built.inserted, built.ignored};
  if (built.map.octree)
    run.report.maps.push_back(mrpt::fusion::reportOn("map", run.args.output, *built.map.octree));
  return true;
}

}  // namespace map_fusion
