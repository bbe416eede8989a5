// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstdint>

/** \file
 * Cubes of the grid of an octree. */

namespace mrpt::fusion {

/** A cube of an octree's grid, by the key of its lowest finest voxel and its depth. */
struct OcTreeCube {
  octomap::OcTreeKey key{0, 0, 0};  ///< Key of the lowest finest voxel
  unsigned depth = 0;               ///< Depth: 0 is the root, 16 is a finest voxel

  static constexpr unsigned kMaxDepth = 16;  ///< Depth of the finest voxels

  /** Returns the side, finest voxels. */
  uint32_t side() const { return 1U << (kMaxDepth - depth); }

  /** True if the other cube is this cube or lies within it. */
  bool contains(const OcTreeCube& o) const {
    if (o.depth < depth) return false;
    for (unsigned axis = 0; axis < 3; axis++)
      if ((key[axis] ^ o.key[axis]) >> (kMaxDepth - depth)) return false;
    return true;
  }

  /** Returns the i-th of 8 children, in OctoMap's order (bit 0: x, bit 1: y, bit 2: z). */
  OcTreeCube child(unsigned i) const {
    const unsigned height = kMaxDepth - depth - 1;
    const auto part = [&](unsigned axis) {
      return static_cast<octomap::key_type>(key[axis] + ((i >> axis & 1U) << height));
    };
    return {{part(0), part(1), part(2)}, depth + 1};
  }
};

/** Returns the node of the i-th child cube of a node's cube, for traversals deeper than the octree.
 * A leaf counts as all cubes in it: for a leaf the function returns the leaf itself.
 * \param[in] tree The octree of the node.
 * \param[in] node The node; null if its cube is unknown.
 * \param[in] i Number of the child in OctoMap's order.
 * \return Null if the child's cube is unknown. */
inline const octomap::OcTreeNode* childOrSelf(const octomap::OcTree& tree,
                                              const octomap::OcTreeNode* node, unsigned i) {
  if (!node || !tree.nodeHasChildren(node)) return node;
  return tree.nodeChildExists(node, i) ? tree.getNodeChild(node, i) : nullptr;
}

/** Calls `f(key)` for the voxels on the faces of a cube. */
template <class F>
void forEachFaceVoxel(const OcTreeCube& cube, F&& f) {
  const uint32_t side = cube.side();
  const auto is_face = [side](uint32_t i) { return i == 0 || i == side - 1; };
  const auto part = [&](unsigned axis, uint32_t i) {
    return static_cast<octomap::key_type>(cube.key[axis] + i);
  };
  for (uint32_t z = 0; z < side; z++)
    for (uint32_t y = 0; y < side; y++)
      for (uint32_t x = 0; x < side; x++)
        if (is_face(x) || is_face(y) || is_face(z))
          f(octomap::OcTreeKey(part(0, x), part(1, y), part(2, z)));
}

}  // namespace mrpt::fusion
