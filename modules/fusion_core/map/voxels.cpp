// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Extracts occupied and free voxels from an octree. */
#include <octomap/octomap_utils.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "fusion_base/remembered_function.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_octree/walk.h"

namespace mrpt::fusion {
namespace {

/** Returns the largest number of occupied voxels for an octree. A tiny file can hold leaves with
 * billions of voxels. In a map that was seen by a sensor, most occupied leaves are one voxel. */
size_t mostVoxelsFor(const octomap::OcTree& map, size_t max_voxels) {
  constexpr size_t kLeast = 4'000'000, kPerNode = 64;
  return std::min(max_voxels, kLeast + kPerNode * map.size());
}

/** One traversal of an octree that collects occupied and free voxels. */
class Extraction {
 public:
  /** \param[out] free Receives the free space; may be null. */
  Extraction(const octomap::OcTree& map, size_t max_voxels, FreeSpace* free)
      : map_(map), max_voxels_(mostVoxelsFor(map, max_voxels)), free_(free) {
    voxels_.resolution = map.getResolution();
    // More than most maps need, so that the arrays do not grow. Unused memory is not touched.
    const size_t enough = map.size() / 4;
    voxels_.centre.reserve(enough);
    voxels_.probability.reserve(enough);
    voxels_.key.reserve(enough);
  }

  OccupiedVoxels run() {
    if (const octomap::OcTreeNode* root = map_.getRoot()) walk(*root, {});
    if (free_) free_->index();
    return std::move(voxels_);
  }

 private:
  void walk(const octomap::OcTreeNode& node, const OcTreeCube& cube) {
    if (!map_.nodeHasChildren(&node))
      addLeaf(node, cube);
    else if (cube.depth == FreeSpace::kBlock)
      walkBlock(node, cube);
    else
      for (unsigned i = 0; i < 8; i++)
        if (map_.nodeChildExists(&node, i)) walk(*map_.getNodeChild(&node, i), cube.child(i));
  }

  /** Collects the voxels of a block of 4x4x4 voxels. Most leaves are in blocks that are not
   * completely free. There a leaf costs one bit of a mask instead of a cube. */
  void walkBlock(const octomap::OcTreeNode& node, const OcTreeCube& block) {
    uint64_t free = 0;
    for (unsigned i = 0; i < 8; i++) {
      if (!map_.nodeChildExists(&node, i)) continue;
      const octomap::OcTreeNode& child = *map_.getNodeChild(&node, i);
      if (!map_.nodeHasChildren(&child)) {
        if (map_.isNodeOccupied(child))
          addOccupied(child, block.child(i));
        else
          free |= uint64_t{0xFF} << (8 * i);
        continue;
      }
      for (unsigned j = 0; j < 8; j++) {
        if (!map_.nodeChildExists(&child, j)) continue;
        const octomap::OcTreeNode& leaf = *map_.getNodeChild(&child, j);
        if (map_.isNodeOccupied(leaf))
          addOccupied(leaf, block.child(i).child(j));
        else
          free |= uint64_t{1} << (8 * i + j);
      }
    }
    if (free_ && free) free_->addBlock(block.key, free);
  }

  void addLeaf(const octomap::OcTreeNode& leaf, const OcTreeCube& cube) {
    if (map_.isNodeOccupied(leaf))
      addOccupied(leaf, cube);
    else if (free_)
      free_->addCube(cube);
  }

  void addOccupied(const octomap::OcTreeNode& leaf, const OcTreeCube& cube) {
    const uint64_t volume = uint64_t{1} << (3 * (OcTreeCube::kMaxDepth - cube.depth));
    if (volume > max_voxels_ - voxels_.size())
      throw std::length_error("the map has more than " + std::to_string(max_voxels_) +
                              " occupied voxels: too many for a map of " +
                              std::to_string(map_.size()) + " nodes");
    const auto probability = static_cast<float>(probability_(leaf.getLogOdds()));
    forEachVoxel(cube, [&](const octomap::OcTreeKey& key) {
      voxels_.centre.emplace_back(static_cast<float>(map_.keyToCoord(key[0])),
                                  static_cast<float>(map_.keyToCoord(key[1])),
                                  static_cast<float>(map_.keyToCoord(key[2])));
      voxels_.probability.push_back(probability);
      voxels_.key.push_back(key);
    });
  }

  const octomap::OcTree& map_;
  size_t max_voxels_;
  FreeSpace* free_;
  OccupiedVoxels voxels_;
  RememberedFunction<double (*)(double)> probability_{octomap::probability};
};

}  // namespace

OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map, size_t max_voxels) {
  return Extraction(map, max_voxels, nullptr).run();
}

OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map, FreeSpace& free,
                                     size_t max_voxels) {
  return Extraction(map, max_voxels, &free).run();
}

Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p.cast<double>();
  return sum / static_cast<double>(std::max<size_t>(1, points.size()));
}

size_t strideFor(size_t voxels, size_t enough) {
  return enough == 0 ? 1 : std::max<size_t>(1, (voxels + enough - 1) / enough);
}

}  // namespace mrpt::fusion
