// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Finds the blocks in which two maps overlap. */
#include "fusion_link/wanted.h"

#include <algorithm>
#include <map>
#include <utility>

#include "fusion_octree/walk.h"

namespace mrpt::fusion {
namespace {

octomap::point3d toPoint(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/** Returns the block of a map that contains a point (m, map frame); 0 if there is none. */
BlockCode blockAt(const MapIndex& index, const octomap::OcTree& grid, const octomap::point3d& p) {
  OcTreeCube voxel;
  voxel.depth = OcTreeCube::kMaxDepth;
  if (!keyAt(grid, p, voxel.key)) return 0;
  for (BlockCode code = codeOf(voxel); code; code >>= 3U)
    if (index.blocks.count(code) > 0) return code;
  return 0;
}

}  // namespace

std::vector<BlockCode> blocksOfOverlap(const MapIndex& index, const octomap::OcTree& outline,
                                       const octomap::OcTree& own,
                                       const Eigen::Isometry3d& T_own_other) {
  const octomap::OcTree grid(index.trunk.resolution);
  std::map<BlockCode, size_t> overlap;  // obstacles of the outline in space that this robot knows
  for (auto leaf = outline.begin_leafs(); leaf != outline.end_leafs(); ++leaf) {
    if (!outline.isNodeOccupied(*leaf)) continue;
    const octomap::point3d p = leaf.getCoordinate();
    const Eigen::Vector3d in_own = T_own_other * Eigen::Vector3d(p.x(), p.y(), p.z());
    octomap::OcTreeKey key;
    if (!keyAt(own, toPoint(in_own), key) || !own.search(key)) continue;
    if (const BlockCode block = blockAt(index, grid, p)) overlap[block]++;
  }
  std::vector<std::pair<size_t, BlockCode>> order;
  for (const auto& [code, count] : overlap) order.emplace_back(count, code);
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  std::vector<BlockCode> blocks;
  for (const auto& block : order) blocks.push_back(block.second);
  return blocks;
}

}  // namespace mrpt::fusion
