// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "fusion_report/page/page.h"

/** \file
 * The graph of a team, and the uncertainties of poses, as places in a picture. */

namespace mrpt::fusion {

/** Nodes and links to draw above the maps. */
struct TeamPicture {
  /** A map. */
  struct Node {
    size_t map;                                ///< Index of the map in the scene
    Eigen::Vector3d at;                        ///< Middle of the map, above all maps, m
    std::optional<Eigen::Matrix3d> half_axes;  ///< Enlarged ellipsoid, as columns, m
  };
  /** A match. */
  struct Link {
    size_t a, b;          ///< Indices of the maps
    std::string verdict;  ///< "sure", "held", "refuted", "rejected" or "edges", see linkOf()
  };
  std::vector<Node> nodes;
  std::vector<Link> links;
  double enlarged = 1;  ///< Factor of the ellipsoids of 3 standard deviations
};

/** Returns what the result of a team makes of a match: "sure" if the match would be accepted alone
 * and the maps lie as it says; "held" if only the team confirms it; "refuted" if it would be
 * accepted alone, but the team places a map elsewhere or not at all; otherwise "rejected". */
const char* linkOf(const TeamPair& pair);

/** Returns the nodes of the placed maps of a team, or the node of map B of a pair. Ellipsoids are
 * enlarged by one factor so that they are seen; those of maps that slide are cut off. */
TeamPicture pictureOf(const Report& report, const PageScene& scene);

}  // namespace mrpt::fusion
