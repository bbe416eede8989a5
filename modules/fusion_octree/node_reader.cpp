// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads the nodes of octrees. */
#include "fusion_octree/node_reader.h"

#include <cmath>

#include "fusion_octree/build.h"

namespace mrpt::fusion {
namespace {

void checkDepth(unsigned depth) {
  if (depth > OcTreeCube::kMaxDepth) corrupt("the map's data is corrupt: nodes deeper than 16");
}

}  // namespace

size_t NodeReader::read(NodeLayout layout) {
  octomap::OcTreeNode* root = OcTreeAccess::createRoot(tree_);
  if (layout == NodeLayout::Kinds) return readKinds(root, 0);
  return readNode(root, 0, layout == NodeLayout::LogOddsAndColour);
}

/** Reads a node of a `.ot` body and all nodes below it. \return Number of nodes read. */
size_t NodeReader::readNode(octomap::OcTreeNode* node, unsigned depth, bool has_colour) {
  checkDepth(depth);
  node->setLogOdds(takeLogOdds());
  if (has_colour) takeColour();
  const auto children = in_.take<uint8_t>();
  size_t count = 1;
  for (unsigned i = 0; i < 8; i++)
    if ((children >> i) & 1U) count += readNode(createChild(node, i), depth + 1, has_colour);
  return count;
}

/** Reads the children of a node of a `.bt` body. Each has 2 bits: 0 unknown, 1 free, 2 occupied, 3
 * has children. \return Number of nodes read, including this node. */
size_t NodeReader::readKinds(octomap::OcTreeNode* node, unsigned depth) {
  const auto children = in_.take<uint16_t>();
  if (children) checkDepth(depth + 1);
  size_t count = 1;
  for (unsigned i = 0; i < 8; i++) {
    const unsigned kind = (children >> (2 * i)) & 3U;
    if (!kind) continue;
    auto* child = createChild(node, i);
    if (kind != 3) {
      child->setLogOdds(kind == 2 ? tree_.getClampingThresMaxLog()
                                  : tree_.getClampingThresMinLog());
      count++;
    }
  }
  // OctoMap's order: first all 8 kinds, then the subtrees.
  for (unsigned i = 0; i < 8; i++)
    if (((children >> (2 * i)) & 3U) == 3)
      count += readKinds(tree_.getNodeChild(node, i), depth + 1);
  if (children)
    node->updateOccupancyChildren();
  else
    corrupt("the map's data is corrupt: an inner node without children");
  return count;
}

float NodeReader::takeLogOdds() {
  const auto log_odds = in_.take<float>();
  if (std::isfinite(log_odds)) return log_odds;
  if (std::isnan(log_odds) || infinities_ == Infinities::Reject)
    corrupt("the map's data is corrupt: log-odds that are not finite");
  has_clamped_ = true;
  return log_odds > 0 ? tree_.getClampingThresMaxLog() : tree_.getClampingThresMinLog();
}

void NodeReader::takeColour() {
  constexpr std::string_view kUnset = "\xff\xff\xff";  // see octomap's isColorSet()
  if (in_.takeBytes(kUnset.size()) != kUnset) has_colours_ = true;
}

octomap::OcTreeNode* NodeReader::createChild(octomap::OcTreeNode* node, unsigned i) {
  constexpr size_t kNode = sizeof(octomap::OcTreeNode), kChildren = 8 * sizeof(void*);
  const size_t needed = tree_.nodeHasChildren(node) ? kNode : kNode + kChildren;
  if (needed > memory_)
    corrupt("the map's data is corrupt: its nodes need too much memory for a file of its size");
  memory_ -= needed;
  return tree_.createNodeChild(node, i);
}

}  // namespace mrpt::fusion
