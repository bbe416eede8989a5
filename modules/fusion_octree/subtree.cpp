// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Joins parts of an octree bottom-up. */
#include "fusion_octree/subtree.h"

#include <limits>

#include "fusion_base/bits.h"
#include "fusion_octree/tree_access.h"

namespace mrpt::fusion {
namespace {

using octomap::OcTreeNode;
using Slots = octomap::AbstractOcTreeNode**;

/** Adds the array of the 8 children to a node. */
Slots addSlots(OcTreeNode& node) {
  return OcTreeAccess::childrenOf(node) = new octomap::AbstractOcTreeNode*[8]();
}

OcTreeNode* newLeaf(float log_odds) {
  auto* leaf = new OcTreeNode();
  leaf->setLogOdds(log_odds);
  return leaf;
}

}  // namespace

Subtree Subtree::withoutChildren() {
  Subtree inner;
  inner.node_ = new OcTreeNode();
  inner.kind_ = Kind::Inner;
  inner.nodes_ = 1;
  return inner;
}

Subtree Subtree::joined(Children& children) {
  unsigned known = 0;
  bool equal = true;
  for (unsigned i = 0; i < 8; i++) {
    const Subtree& child = children[i];
    known += child.kind_ != Kind::Unknown;
    equal &= child.kind_ == Kind::Leaf && child.value_ == children[0].value_;
  }
  if (known == 0) return {};
  if (equal) return Subtree(children[0].value_);
  Subtree joined = withoutChildren();
  const Slots slots = addSlots(*joined.node_);
  float highest = -std::numeric_limits<float>::max();
  for (unsigned i = 0; i < 8; i++) {
    Subtree& child = children[i];
    if (child.kind_ == Kind::Unknown) continue;
    if (child.value_ > highest) highest = child.value_;
    joined.nodes_ += child.kind_ == Kind::Leaf ? 1 : child.nodes_;
    slots[i] =
        child.kind_ == Kind::Leaf ? newLeaf(child.value_) : std::exchange(child.node_, nullptr);
  }
  joined.value_ = highest;
  joined.node_->setLogOdds(highest);
  return joined;
}

Subtree Subtree::ofVoxels(const float* value, unsigned known) {
  if (known == 0) return {};
  if (known == 0xFFU) {
    bool equal = true;
    for (unsigned i = 1; i < 8; i++) equal &= value[i] == value[0];
    if (equal) return Subtree(value[0]);
  }
  Subtree joined = withoutChildren();
  const Slots slots = addSlots(*joined.node_);
  float highest = -std::numeric_limits<float>::max();
  for (unsigned left = known; left; left &= left - 1) {
    const auto i = static_cast<unsigned>(lowestBit(left));
    slots[i] = newLeaf(value[i]);
    joined.nodes_++;
    if (value[i] > highest) highest = value[i];
  }
  joined.value_ = highest;
  joined.node_->setLogOdds(highest);
  return joined;
}

Subtree Subtree::of(const VoxelBlock& block) {
  if (block.known == 0) return {};
  Children children;
  for (unsigned i = 0; i < 8; i++)
    children[i] = ofVoxels(&block.value[size_t{8} * i],
                           static_cast<unsigned>(block.known >> (8 * i) & 0xFFU));
  return joined(children);
}

Subtree Subtree::copyOf(const OcTreeNode& node, unsigned depth) {
  if (!OcTreeAccess::hasChildren(node)) return Subtree(node.getLogOdds());
  if (depth + 1 == OcTreeCube::kMaxDepth) {
    std::array<float, 8> value;
    unsigned known = 0;
    for (unsigned i = 0; i < 8; i++)
      if (const auto* child = OcTreeAccess::child(node, i)) {
        value[i] = child->getLogOdds();
        known |= 1U << i;
      }
    return ofVoxels(value.data(), known);
  }
  Children children;
  for (unsigned i = 0; i < 8; i++)
    if (const auto* child = OcTreeAccess::child(node, i)) children[i] = copyOf(*child, depth + 1);
  return joined(children);
}

void Subtree::moveInto(octomap::OcTree& tree) {
  if (kind_ == Kind::Unknown) return;
  if (kind_ == Kind::Leaf)
    OcTreeAccess::setRoot(tree, newLeaf(value_), 1);
  else
    OcTreeAccess::setRoot(tree, std::exchange(node_, nullptr), nodes_);
  kind_ = Kind::Unknown;
}

void Subtree::destroy(OcTreeNode* node) {
  if (Slots slots = OcTreeAccess::childrenOf(*node)) {
    for (unsigned i = 0; i < 8; i++)
      if (slots[i]) destroy(static_cast<OcTreeNode*>(slots[i]));
    delete[] slots;
    OcTreeAccess::childrenOf(*node) = nullptr;
  }
  delete node;
}

}  // namespace mrpt::fusion
