// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/evaluation.h>
#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "fusion_report/report.h"

/** \file
 * A report as a page: one HTML file with a picture in 3-D, which loads nothing. */

namespace mrpt::fusion {

/** A map in the picture of a page. */
struct PageMap {
  std::string name;                                        ///< "A", "B", or a robot's name
  std::shared_ptr<const octomap::OcTree> octree;           ///< The map, never null
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< Pose in the frame of the picture
  bool is_shown = true;                     ///< False for a map that is hidden until the user asks
  std::shared_ptr<const EdgeVoxels> edges;  ///< Structural edges; null: none are shown
};

/** What the picture of a page shows. Pairs, rival poses, the graph of a team and covariances come
 * from the report. */
struct PageScene {
  /** What the maps are to each other. */
  enum class Kind {
    Maps,  ///< Maps without a match
    Pair,  ///< Maps A and B
    Team   ///< Maps of the members of the report, in their order
  };
  Kind kind = Kind::Maps;                        ///< Kind
  std::vector<PageMap> maps;                     ///< The maps
  std::shared_ptr<const octomap::OcTree> fused;  ///< Fused map in the frame of the picture, or null
  EvaluationParams limits;                       ///< Limits of the verdict
};

/** Returns the picture of a page as JSON, for toPage(). Large maps are drawn by coarser cubes.
 * Cost: O(nodes of all maps), and O(voxels * maps) for the conflicts. */
std::string toSceneJson(const Report& report, const PageScene& scene);

/** Returns a page. It holds the report as toJson() writes it, and shows its numbers. Names and
 * paths cannot become part of the page's markup or script. \param[in] scene_json See toSceneJson().
 */
std::string toPage(const Report& report, const std::string& scene_json);

/** True if a file begins as toPage() writes it. \param[in] beginning First 64 bytes of the file. */
bool isPage(std::string_view beginning);

}  // namespace mrpt::fusion
