// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Copies the values of an octree to arrays. */
#include "fusion_octree/block_tree.h"

#include <algorithm>

#include "fusion_base/bits.h"
#include "fusion_octree/tree_access.h"

namespace mrpt::fusion {

BlockTree::BlockTree(const octomap::OcTree& tree) {
  const auto* root = tree.getRoot();
  if (!root) return;
  nodes_.emplace_back();
  const Node made_root = made(tree, *root, 0);  // moves nodes_
  nodes_[0] = made_root;
}

BlockTree::Node BlockTree::made(const octomap::OcTree& tree, const octomap::OcTreeNode& node,
                                unsigned depth) {
  Node made_node;
  if (!OcTreeAccess::hasChildren(node)) {
    made_node.log_odds = node.getLogOdds();
    return made_node;
  }
  if (depth == VoxelBlock::kDepth) {
    made_node.kind = Kind::Block;
    made_node.values = addBlock(node);
    return made_node;
  }
  made_node.kind = Kind::Inner;
  uint32_t count = 0;
  for (unsigned i = 0; i < 8; i++)
    if (OcTreeAccess::child(node, i)) {
      made_node.children |= static_cast<uint8_t>(1U << i);
      count++;
    }
  made_node.first = static_cast<uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + count);
  uint32_t place = made_node.first;
  for (unsigned i = 0; i < 8; i++)
    if (const auto* child = OcTreeAccess::child(node, i)) {
      const Node made_child = made(tree, *child, depth + 1);
      nodes_[place++] = made_child;
    }
  return made_node;
}

const BlockTree::Values* BlockTree::addBlock(const octomap::OcTreeNode& node) {
  Values& values = blocks_.add();
  values.fill(kUnknown);
  for (unsigned i = 0; i < 8; i++) {
    const auto* child = OcTreeAccess::child(node, i);
    if (!child) continue;
    if (!OcTreeAccess::hasChildren(*child)) {
      for (unsigned j = 0; j < 8; j++)
        values[VoxelBlock::kRowIndex[8 * i + j]] = child->getLogOdds();
      continue;
    }
    for (unsigned j = 0; j < 8; j++)
      if (const auto* voxel = OcTreeAccess::child(*child, j))
        values[VoxelBlock::kRowIndex[8 * i + j]] = voxel->getLogOdds();
  }
  return &values;
}

float BlockTree::at(uint32_t x, uint32_t y, uint32_t z) const {
  if (empty()) return kUnknown;
  const Node* node = &nodes_[0];
  for (unsigned bit = OcTreeCube::kMaxDepth; node->kind == Kind::Inner;) {
    bit--;
    const unsigned i = (x >> bit & 1U) | (y >> bit & 1U) << 1U | (z >> bit & 1U) << 2U;
    if (!(node->children >> i & 1U)) return kUnknown;
    node =
        &nodes_[node->first + static_cast<uint32_t>(countBits(node->children & ((1U << i) - 1)))];
  }
  return node->kind == Kind::Leaf ? node->log_odds : (*node->values)[indexOf(x, y, z)];
}

Eigen::AlignedBox3d BlockTree::knownBlocks(double resolution) const {
  constexpr double kOrigin = 1U << (OcTreeCube::kMaxDepth - 1);
  Eigen::AlignedBox3d box;
  forEachLeafOrBlock([&](const Node&, const OcTreeCube& cube) {
    const Eigen::Vector3d low = Eigen::Array3d(cube.key[0], cube.key[1], cube.key[2]) - kOrigin;
    box.extend(low);
    box.extend((low.array() + cube.side()).matrix());
  });
  return {resolution * box.min(), resolution * box.max()};
}

}  // namespace mrpt::fusion
