// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion build`. */

#include <stdexcept>

#include "commands/commands.h"
#include "fusion_base/files.h"
#include "inputs.h"
#include "mrpt_maps.h"
#include "output.h"

namespace map_fusion {

namespace {

/** Builds a map from a point cloud. */
void buildFromCloud(RunContext& run) {
  const LoadedMap map = loadMap(run, "map", run.args.maps[0]);
  saveMap(map.octree, run.args.output, map.sources);
  run.endStep("save");
  run.report.maps.back().path = run.args.output;
}

}  // namespace

bool runBuild(RunContext& run) {
  const std::string& recording = run.args.maps[0];
  const InputKind kind = inputKindOf(run, recording);
  if (kind == InputKind::OcTree || kind == InputKind::RawNodes)
    throw std::runtime_error(recording + ": is a map, not a recording");
  if (kind == InputKind::PointCloud) {
    buildFromCloud(run);
    return true;
  }
  if (run.args.resolution > 0 || !run.args.sensor_origin.empty())
    throw std::runtime_error(recording +
                             ": is a recording: its map is defined by --config, not by "
                             "--resolution or --sensor-origin");
  const auto built = mrptMaps().build(recording, run.mapDefinition());
  run.progress.clear();
  for (const auto& note : built.map.notes) run.note(recording + ": " + note);
  run.endStep("build");
  if (run.args.output == mrpt::fusion::kStandardOutput && built.map.octree)
    saveMap(built.map.octree, run.args.output);
  else
    mrptMaps().save(built.map, run.args.output);
  run.wrote(run.args.output);
  run.endStep("save");
  run.report.observations = built.observations;
  if (built.map.octree)
    run.report.maps.push_back(mrpt::fusion::reportOn("map", run.args.output, *built.map.octree));
  return true;
}

}  // namespace map_fusion
