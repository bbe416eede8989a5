// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion slice`. */

#include "fusion_octree/slice.h"

#include <octomap/octomap_utils.h>

#include <limits>
#include <stdexcept>

#include "commands/commands.h"
#include "fusion_base/error_text.h"
#include "inputs.h"
#include "slice_out.h"

using mrpt::fusion::CellKind;
using mrpt::fusion::CellThresholds;
using mrpt::fusion::MapSlice;

namespace map_fusion {
namespace {

/** Cuts the slice of the arguments. \exception std::runtime_error If it is empty. */
MapSlice cut(const RunContext& run, const octomap::OcTree& map) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto& heights = run.args.heights;
  MapSlice slice = heights.empty() ? mrpt::fusion::sliceOf(map, -kInfinity, kInfinity)
                                   : mrpt::fusion::sliceOf(map, heights[0], heights[1]);
  if (slice.log_odds.empty()) throw std::runtime_error("no voxel between these heights is known");
  return slice;
}

CellThresholds thresholdsOf(const RunContext& run, const octomap::OcTree& map) {
  const auto& limits = run.args.thresholds;
  if (limits.empty()) return CellThresholds::of(map);
  return {octomap::logodds(limits[0]), octomap::logodds(limits[1])};
}

mrpt::fusion::SliceReport reportOn(const MapSlice& slice, const CellThresholds& thresholds) {
  mrpt::fusion::SliceReport report{slice.width, slice.height};
  for (const float log_odds : slice.log_odds) {
    const CellKind kind = thresholds.kindOf(log_odds);
    report.occupied += kind == CellKind::Occupied;
    report.free += kind == CellKind::Free;
    report.unknown += kind == CellKind::Unknown;
  }
  return report;
}

}  // namespace

bool runSlice(RunContext& run) {
  const LoadedMap map = loadMap(run, "map", run.args.maps[0]);
  const MapSlice slice =
      mrpt::fusion::withPath(run.args.maps[0], [&] { return cut(run, map.wholeMap()); });
  const CellThresholds thresholds = thresholdsOf(run, *map.octree);
  run.report.slice = reportOn(slice, thresholds);
  run.endStep("slice");
  saveSlice(slice, thresholds, run.args.output);
  for (const std::string& file : outputsOf(run.args))
    if (file != run.args.json) run.wrote(file);
  run.endStep("save");
  return true;
}

}  // namespace map_fusion
