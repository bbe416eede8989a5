// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "fusion_octree/build.h"

/** \file
 * Traversals of the voxels of an octree, with pruned leaves expanded. Octomap's iterators keep a
 * stack and compute a key for every node, which takes 10 times as long.
 */

namespace mrpt::fusion {

namespace detail {
/** Spreads 16 bits to every third bit, from bit 0 on. */
inline uint64_t spread16(uint64_t v) {
  v = (v | v << 16U) & 0x0000FF0000FFULL;
  v = (v | v << 8U) & 0x00F00F00F00FULL;
  v = (v | v << 4U) & 0x0C30C30C30C3ULL;
  return (v | v << 2U) & 0x249249249249ULL;
}
}  // namespace detail

/** Returns the number of a finest voxel in the order of the octree's traversal. */
inline uint64_t octreeOrder(const octomap::OcTreeKey& key) {
  return detail::spread16(key[0]) | detail::spread16(key[1]) << 1U | detail::spread16(key[2]) << 2U;
}

/** Inverts octreeOrder(): returns the key of the i-th of all finest voxels (x fastest). */
inline octomap::OcTreeKey keyInOctreeOrder(uint64_t i) {
  octomap::OcTreeKey key(0, 0, 0);
  for (unsigned bit = 0; i >> (3 * bit); bit++)
    for (unsigned axis = 0; axis < 3; axis++)
      key[axis] |= static_cast<octomap::key_type>((i >> (3 * bit + axis) & 1) << bit);
  return key;
}

/** Gets the key of the finest voxel at a point (m, map frame). Returns false if the point is
 * outside the grid or not finite. OcTree::coordToKeyChecked() converts the coordinates to int
 * before it compares them with the grid: far points overflow. */
inline bool keyAt(const octomap::OcTree& tree, const octomap::point3d& p, octomap::OcTreeKey& key) {
  const double limit = tree.getResolution() * (1U << OcTreeCube::kMaxDepth);  // twice the reach
  for (unsigned axis = 0; axis < 3; axis++)
    if (!(std::abs(p(axis)) <= limit)) return false;
  return tree.coordToKeyChecked(p, key);
}

namespace detail {

/** Calls f for the leaves below a node with children. Most nodes are leaves: a leaf needs no
 * recursive call. */
template <class F>
void forEachLeafBelow(const octomap::OcTreeNode& node, const OcTreeCube& cube, F&& f) {
  for (unsigned i = 0; i < 8; i++) {
    const octomap::OcTreeNode* child = OcTreeAccess::child(node, i);
    if (!child) continue;
    if (OcTreeAccess::hasChildren(*child))
      forEachLeafBelow(*child, cube.child(i), f);
    else
      f(cube.child(i), *child);
  }
}

}  // namespace detail

/** Calls `f(const OcTreeCube&, const OcTreeNode&)` for each leaf, in the order of the octree. */
template <class F>
void forEachLeaf(const octomap::OcTree& tree, F&& f) {
  const octomap::OcTreeNode* root = tree.getRoot();
  if (!root) return;
  if (tree.nodeHasChildren(root))
    detail::forEachLeafBelow(*root, {}, f);
  else
    f(OcTreeCube{}, *root);
}

/** Returns the bounding box of the known space of a map, occupied or free, m; empty for an empty
 * map. Octomap's getMetricMin() and getMetricMax() traverse the map with its iterators, once each.
 */
inline Eigen::AlignedBox3d knownSpace(const octomap::OcTree& map) {
  constexpr uint32_t kMost = 1U << OcTreeCube::kMaxDepth;
  std::array<uint32_t, 3> low{kMost, kMost, kMost}, high{0, 0, 0};
  forEachLeaf(map, [&](const OcTreeCube& cube, const octomap::OcTreeNode&) {
    for (unsigned axis = 0; axis < 3; axis++) {
      low[axis] = std::min<uint32_t>(low[axis], cube.key[axis]);
      high[axis] = std::max<uint32_t>(high[axis], cube.key[axis] + cube.side());
    }
  });
  const auto corner = [&](const std::array<uint32_t, 3>& k) {
    return Eigen::Vector3d(map.getResolution() * (Eigen::Array3d(k[0], k[1], k[2]) - 0.5 * kMost));
  };
  return {corner(low), corner(high)};
}

/** Calls `f(const OcTreeKey&)` for each finest voxel of a cube, in the order of the octree. */
template <class F>
void forEachVoxel(const OcTreeCube& cube, F&& f) {
  const uint64_t volume = uint64_t{1} << (3 * (OcTreeCube::kMaxDepth - cube.depth));
  for (uint64_t i = 0; i < volume; i++) {
    octomap::OcTreeKey key = keyInOctreeOrder(i);
    for (unsigned axis = 0; axis < 3; axis++) key[axis] |= cube.key[axis];
    f(key);
  }
}

}  // namespace mrpt::fusion
