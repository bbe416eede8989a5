// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <array>
#include <cstdint>

#include "fusion_octree/insertion/cell_marks.h"

/** \file
 * Updates of octree nodes from the marks of their voxels.
 */

namespace mrpt::fusion {

/** Access to the protected children of a node. */
struct NodeChildren : octomap::OcTreeNode {
  using Array = octomap::AbstractOcTreeNode**;  ///< 8 pointers, or null

  static Array& of(octomap::OcTreeNode& node) { return node.*(&NodeChildren::children); }
  /** Returns a child. Null if the child does not exist. */
  static octomap::OcTreeNode* get(octomap::OcTreeNode& node, unsigned i) {
    const Array children = of(node);
    return children ? static_cast<octomap::OcTreeNode*>(children[i]) : nullptr;
  }
  /** Returns whether a node has no child. */
  static bool isLeaf(octomap::OcTreeNode& node) {
    const Array children = of(node);
    if (!children) return true;
    for (unsigned i = 0; i < 8; i++)
      if (children[i]) return false;
    return true;
  }
};

/** What a scan does to its voxels. */
struct CellUpdate {
  explicit CellUpdate(const octomap::OcTree& tree, bool prunes);

  float hit;        ///< Change by a hit, log-odds
  float miss;       ///< Change by a miss, log-odds
  float clamp_min;  ///< Lowest log-odds of a voxel
  float clamp_max;  ///< Highest log-odds of a voxel
  bool prune;       ///< Whether equal children are pruned

  /** Returns false if octomap leaves a voxel as it is, because it is at its limit. */
  bool changes(float log_odds, float change) const {
    const bool at_max = (change >= 0) & (log_odds >= clamp_max);
    const bool at_min = (change <= 0) & (log_odds <= clamp_min);
    return !(at_max | at_min);
  }
  /** Returns the new log-odds of a voxel. */
  float updated(float log_odds, float change) const {
    const float sum = log_odds + change;
    const float limited = sum > clamp_max ? clamp_max : sum;
    return sum < clamp_min ? clamp_min : limited;
  }
};

/** Updates nodes of an octree, and counts the nodes. The result is that of
 * octomap::OcTree::updateNode() for each marked voxel, and of updateInnerOccupancy() and prune(). A
 * leaf whose voxels all change alike stays a leaf: it is not expanded and pruned again. */
class NodeUpdater {
 public:
  explicit NodeUpdater(const CellUpdate& update);

  /** Updates a node of the depth of blocks. \param[in,out] node The node. \param[in] is_new True if
   * the node was created for this update. \param[in] marks Marks of its voxels. No voxel is marked
   * as free and as occupied. \return Whether anything has changed. */
  bool updateBlock(octomap::OcTreeNode& node, bool is_new, const BlockMarks& marks);
  /** Returns whether the marks of a block change a leaf that contains the block. */
  bool changesLeaf(float log_odds, const BlockMarks& marks) const;
  /** Creates a child. The node must not have this child. */
  octomap::OcTreeNode* createChild(octomap::OcTreeNode& node, unsigned i);
  /** Creates all children of a leaf, with the value of the leaf. */
  void expand(octomap::OcTreeNode& leaf);
  /** Computes the value of a node from its children. \param[in,out] node The node. \param[in]
   * may_prune Whether equal children are pruned. */
  void finish(octomap::OcTreeNode& node, bool may_prune);

  /** Returns the number of nodes that were created, minus the number of deleted nodes. */
  int64_t created() const { return created_; }

 private:
  struct Part;
  template <unsigned kWords>
  bool update(octomap::OcTreeNode& node, bool is_new, const Part& part);
  template <unsigned kWords>
  bool updateChildren(octomap::OcTreeNode& node, const Part& part);
  bool updateOctet(octomap::OcTreeNode& node, bool is_new, uint32_t free, uint32_t occupied);
  void storeOctet(octomap::OcTreeNode& node, uint32_t exist, const std::array<float, 8>& values);

  CellUpdate update_;
  float new_free_, new_occupied_;  // log-odds of a voxel after its first update
  int64_t created_ = 0;
};

}  // namespace mrpt::fusion
