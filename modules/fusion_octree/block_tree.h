// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "fusion_octree/chunk_store.h"
#include "fusion_octree/cube.h"
#include "fusion_octree/voxel_block.h"

/** \file
 * An octree as arrays, for millions of lookups. */

namespace mrpt::fusion {

/** The nodes of an octree down to cubes of 4 x 4 x 4 voxels, and the voxels in these cubes. */
class BlockTree {
 public:
  /** Kind of a node. */
  enum class Kind : uint8_t {
    Inner,  ///< A node with children
    Leaf,   ///< One value in the whole cube, which is a block or larger
    Block   ///< A block whose voxels differ
  };
  /** Log-odds of the voxels of a block, x fastest; kUnknown for unknown voxels. */
  using Values = std::array<float, VoxelBlock::kVoxels>;
  /** A node. */
  struct Node {
    Kind kind = Kind::Leaf;  ///< Kind of the node
    uint8_t children = 0;    ///< Bit i is set if the node has the i-th child
    uint32_t first = 0;      ///< Number of the first of the children, which follow each other
    float log_odds = 0;      ///< Log-odds of a leaf
    const Values* values = nullptr;  ///< The voxels of a block
  };
  static constexpr float kUnknown = -std::numeric_limits<float>::infinity();

  /** Cost: one traversal of the octree. Memory: 256 bytes for each block. */
  explicit BlockTree(const octomap::OcTree& tree);

  bool empty() const { return nodes_.empty(); }  ///< True for an octree without nodes
  /** Returns a node. Node 0 is the root. */
  const Node& node(uint32_t number) const { return nodes_[number]; }
  /** Returns the number of a voxel in the block that contains it.
   * \param[in] x,y,z Key of the voxel. */
  static unsigned indexOf(uint32_t x, uint32_t y, uint32_t z) {
    return (x & 3U) | (y & 3U) << 2U | (z & 3U) << 4U;
  }
  /** Returns the log-odds of a voxel, or kUnknown. Cost: one descent from the root. */
  float at(uint32_t x, uint32_t y, uint32_t z) const;

  /** Returns the bounding box of the blocks that hold known space, m; empty for an empty octree.
   * \param[in] resolution Voxel size, m. */
  Eigen::AlignedBox3d knownBlocks(double resolution) const;

  /** Calls `f(node, cube)` for each leaf and each block, in the order of the octree. */
  template <class F>
  void forEachLeafOrBlock(F&& f) const {
    if (!empty()) forEachBelow(nodes_[0], {}, f);
  }

 private:
  Node made(const octomap::OcTree& tree, const octomap::OcTreeNode& node, unsigned depth);
  const Values* addBlock(const octomap::OcTreeNode& node);
  template <class F>
  void forEachBelow(const Node& node, const OcTreeCube& cube, F& f) const {
    if (node.kind != Kind::Inner) return f(node, cube);
    uint32_t child = node.first;
    for (unsigned i = 0; i < 8; i++)
      if (node.children >> i & 1U) forEachBelow(nodes_[child++], cube.child(i), f);
  }

  std::vector<Node> nodes_;
  ChunkStore<Values> blocks_;
};

}  // namespace mrpt::fusion
