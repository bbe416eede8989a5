// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion edges`. */

#include <mrpt/fusion/edges.h>

#include <filesystem>
#include <memory>

#include "commands/commands.h"
#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "inputs.h"

using mrpt::fusion::EdgeVoxels;

namespace map_fusion {

bool runEdges(RunContext& run) {
  const LoadedMap map = loadMap(run, "map", run.args.maps[0]);
  const auto edges = mrpt::fusion::withPath(
      run.args.maps[0], [&] { return std::make_shared<const EdgeVoxels>(edgesOf(run, map)); });
  run.report.edges = edges->size();
  run.endStep("edges");
  const std::string& output = run.args.output;
  if (std::filesystem::path(output).extension() == ".ply" ||
      output == mrpt::fusion::kStandardOutput)
    mrpt::fusion::writeFileAtomically(output, toPly(*edges));
  else
    mrptMaps().save({nullptr, edges, nullptr, {}}, output);
  run.wrote(output);
  run.endStep("save");
  return true;
}

}  // namespace map_fusion
