// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <array>
#include <cstddef>
#include <utility>

#include "fusion_octree/voxel_block.h"

/** \file
 * Parts of an octree that is built bottom-up. */

namespace mrpt::fusion {

/** Content of a cube: unknown space, a leaf, or nodes with children. It owns its nodes.
 *
 * A leaf has no node before its siblings are known. So equal siblings are pruned before memory is
 * allocated for them. */
class Subtree {
 public:
  Subtree() = default;  ///< Makes unknown space
  explicit Subtree(float log_odds) : kind_(Kind::Leaf), value_(log_odds) {}  ///< Makes a leaf
  Subtree(Subtree&& o) noexcept
      : kind_(o.kind_), value_(o.value_), node_(std::exchange(o.node_, nullptr)), nodes_(o.nodes_) {
    o.kind_ = Kind::Unknown;
  }
  Subtree& operator=(Subtree&& o) noexcept {
    std::swap(kind_, o.kind_);
    std::swap(value_, o.value_);
    std::swap(node_, o.node_);
    std::swap(nodes_, o.nodes_);
    return *this;
  }
  ~Subtree() {
    if (node_) destroy(node_);
  }

  /** The 8 children of a cube, in OctoMap's order. */
  using Children = std::array<Subtree, 8>;
  /** Joins the children of a cube. Equal leaves become one leaf. The node of the cube has the
   * maximum of its children, as in OctoMap. */
  static Subtree joined(Children& children);
  /** Returns the content of a block of voxels. */
  static Subtree of(const VoxelBlock& block);
  /** Returns a pruned copy of a node with all nodes below it.
   * \param[in] node The node.
   * \param[in] depth Depth of the node. */
  static Subtree copyOf(const octomap::OcTreeNode& node, unsigned depth);

  bool isUnknown() const { return kind_ == Kind::Unknown; }  ///< True for unknown space
  /** Moves the content into an empty octree, as the content of its whole grid. */
  void moveInto(octomap::OcTree& tree);

 private:
  enum class Kind { Unknown, Leaf, Inner };

  /** Makes a node that is to get children. */
  static Subtree withoutChildren();
  static Subtree ofVoxels(const float* value, unsigned known);
  static void destroy(octomap::OcTreeNode* node);

  Kind kind_ = Kind::Unknown;
  float value_ = 0;                      // log-odds
  octomap::OcTreeNode* node_ = nullptr;  // of Kind::Inner
  size_t nodes_ = 0;                     // number of nodes below the node, and the node itself
};

}  // namespace mrpt::fusion
