// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion transform`. */

#include <mrpt/fusion/poses.h>

#include <memory>

#include "commands/commands.h"
#include "fusion_base/error_text.h"
#include "fusion_octree/resampling.h"
#include "fusion_octree/voxel_hash.h"
#include "inputs.h"
#include "output.h"
#include "pose.h"

namespace map_fusion {

bool runTransform(RunContext& run) {
  const mrpt::poses::CPose3D pose = parsePose(run.args.pose);
  const LoadedMap map = loadMap(run, "map", run.args.maps[0]);
  run.uses_resolution = true;
  const double resolution =
      run.args.resolution > 0 ? run.args.resolution : map.octree->getResolution();
  const auto moved =
      mrpt::fusion::withPath(run.args.maps[0], [&]() -> std::shared_ptr<const octomap::OcTree> {
        return mrpt::fusion::transformOcTree(*map.octree, mrpt::fusion::toEigen(pose), resolution);
      });
  run.endStep("transform");
  mrpt::fusion::Sources sources = map.sources;  // the observations stay the same
  for (auto& source : sources)
    if (source.content_hash == 0) source.content_hash = mrpt::fusion::voxelHash(*map.octree);
  saveMap(moved, run.args.output, sources);
  run.wrote(run.args.output);
  run.endStep("save");
  run.report.maps.push_back(mrpt::fusion::reportOn("transformed", run.args.output, *moved));
  return true;
}

}  // namespace map_fusion
