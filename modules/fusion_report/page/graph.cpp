// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Places the nodes of a team in a picture. */

#include "fusion_report/page/graph.h"

#include <algorithm>
#include <cmath>

#include "fusion_octree/walk.h"
#include "fusion_report/page/covariance.h"

namespace mrpt::fusion {
namespace {

/** Box and middle of the occupied voxels of a map, map frame, m. */
struct Extent {
  Eigen::AlignedBox3d box;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
};

Extent extentOf(const octomap::OcTree& map) {
  Extent extent;
  double weight = 0;
  const double r = map.getResolution(), half_grid = 1U << (OcTreeCube::kMaxDepth - 1);
  forEachLeaf(map, [&](const OcTreeCube& cube, const octomap::OcTreeNode& node) {
    if (!map.isNodeOccupied(node)) return;
    const Eigen::Vector3d low =
        r * (Eigen::Array3d(cube.key[0], cube.key[1], cube.key[2]) - half_grid);
    const double side = r * cube.side(), w = std::pow(cube.side(), 3);
    const Eigen::Vector3d size = Eigen::Vector3d::Constant(side);
    extent.box.extend(low).extend(low + size);
    extent.middle += w * (low + 0.5 * size);
    weight += w;
  });
  if (weight > 0) extent.middle /= weight;
  return extent;
}

bool isKnown(const mrpt::poses::CPose3DPDFGaussian& pose) {
  return pose.cov.asEigen().allFinite() && pose.cov.asEigen().diagonal().maxCoeff() > 0;
}

/** Returns the largest of 1, 2, 5, 10, 20, ... that is at most a number; at least 1. */
double roundFactor(double most) {
  if (!(most > 1)) return 1;
  const double power = std::pow(10, std::floor(std::log10(most)));
  return power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
}

}  // namespace

const char* linkOf(const TeamPair& pair) {
  if (pair.holds) return pair.accepted ? "sure" : "held";
  return pair.accepted ? "refuted" : "rejected";
}

TeamPicture pictureOf(const Report& report, const PageScene& scene) {
  TeamPicture picture;
  const bool is_team = scene.kind == PageScene::Kind::Team;
  if (!is_team && !(scene.kind == PageScene::Kind::Pair && report.match)) return picture;
  Eigen::AlignedBox3d all;
  std::vector<Extent> extents;
  for (const PageMap& map : scene.maps) {
    extents.push_back(extentOf(*map.octree));
    if (map.is_shown && !extents.back().box.isEmpty())
      all.extend(extents.back().box.transformed(map.pose));
  }
  if (all.isEmpty()) return picture;
  const double size = all.diagonal().norm();
  const double above = all.max().z() + (is_team ? 0.04 : 0.02) * size;

  double largest = 0;  // largest half-axis of a map that does not slide
  const double cut_off = 0.2 * size;
  for (size_t i = is_team ? 0 : 1; i < scene.maps.size(); i++) {
    const PageMap& map = scene.maps[i];
    if (!map.is_shown && is_team && !report.members[i].hasMatch()) continue;
    TeamPicture::Node node{i, map.pose * extents[i].middle, std::nullopt};
    node.at.z() = above;
    const auto* pose = is_team ? &report.members[i].pose : report.pose ? &*report.pose : nullptr;
    if (pose && isKnown(*pose)) {
      node.half_axes = ellipsoidOf(covarianceOf(*pose, extents[i].middle));
      const double longest = node.half_axes->colwise().norm().maxCoeff();
      if (longest < cut_off) largest = std::max(largest, longest);
    }
    picture.nodes.push_back(node);
  }
  picture.enlarged = largest > 0 ? roundFactor(0.05 * size / largest) : 1;
  for (auto& node : picture.nodes)
    if (node.half_axes) {
      *node.half_axes *= picture.enlarged;
      for (int k = 0; k < 3; k++) {
        const double length = node.half_axes->col(k).norm();
        if (length > cut_off) node.half_axes->col(k) *= cut_off / length;
      }
    }
  const auto indexOf = [&](const std::string& robot) {
    return static_cast<size_t>(std::find_if(scene.maps.begin(), scene.maps.end(),
                                            [&](const PageMap& map) { return map.name == robot; }) -
                               scene.maps.begin());
  };
  for (const TeamPair& p : report.pairs)
    picture.links.push_back({indexOf(p.a), indexOf(p.b), linkOf(p)});
  // Maps that have only edges are in no pair, and two maps of a mission have no pairs.
  for (size_t i = 0; is_team && i < report.members.size(); i++) {
    const FusionMember& m = report.members[i];
    if (!m.hasMatch() || (!m.alignment.by_edges && !report.pairs.empty())) continue;
    const char* verdict = m.alignment.by_edges              ? "edges"
                          : m.alignment.evaluation.accepted ? "sure"
                                                            : "rejected";
    picture.links.push_back({indexOf(m.matched_with), i, verdict});
  }
  return picture;
}

}  // namespace mrpt::fusion
