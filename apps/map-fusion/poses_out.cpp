// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Writes the poses of all placed robots. */

#include "poses_out.h"

#include <filesystem>

#include "fusion_report/pose_graph.h"
#include "mrpt_maps.h"

namespace map_fusion {

namespace {

std::string extensionOf(const std::string& path) { return std::filesystem::path(path).extension(); }

}  // namespace

bool isPosesFile(const std::string& path) {
  const std::string extension = extensionOf(path);
  return extension == ".g2o" || extension == ".graph" || extension == ".tum" ||
         extension == ".yaml";
}

void savePoses(RunContext& run, bool is_merged) {
  const std::string& path = run.args.poses_out;
  if (path.empty()) return;
  const auto graph = mrpt::fusion::poseGraphOf(run.report, is_merged);
  const std::string extension = extensionOf(path);
  const std::string text = extension == ".g2o"    ? toG2o(graph)
                           : extension == ".tum"  ? toTum(graph)
                           : extension == ".yaml" ? toYaml(graph)
                                                  : mrptMaps().toGraphText(graph);
  run.write(path, text);
  run.endStep("poses");
}

}  // namespace map_fusion
