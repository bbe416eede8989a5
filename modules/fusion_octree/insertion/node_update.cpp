// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Updates of octree nodes from the marks of their voxels. */

#include "fusion_octree/insertion/node_update.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion_base/bits.h"

namespace mrpt::fusion {

using octomap::AbstractOcTreeNode;
using octomap::OcTreeNode;

namespace {

/** Value below all log-odds. octomap begins with it when it computes the largest child. */
constexpr float kLowest = std::numeric_limits<float>::lowest();
constexpr uint32_t kAll8 = 0xff;

/** Loads the nodes of the marked voxels of a block into the cache, level by level. Each node is
 * behind a pointer. The update would wait for one node after the other. Here the nodes of a level
 * are on their way at the same time. */
void prefetchNodes(OcTreeNode& block, const BlockMarks& marks) {
  struct Octet {
    OcTreeNode* node;
    NodeChildren::Array voxels;
  };
  std::array<OcTreeNode*, BlockMarks::kWords> nodes{};  // by word
  std::array<Octet, 8 * BlockMarks::kWords> octets;
  size_t count = 0;
  const auto marked = [&](unsigned word) { return marks.free[word] | marks.occupied[word]; };
  for (unsigned w = 0; w < BlockMarks::kWords; w++) {
    if (!marked(w)) continue;
    OcTreeNode* const parent = NodeChildren::get(block, w / 8);
    nodes[w] = parent ? NodeChildren::get(*parent, w % 8) : nullptr;
    __builtin_prefetch(nodes[w]);
  }
  for (OcTreeNode* const node : nodes)
    if (node) __builtin_prefetch(NodeChildren::of(*node));
  for (unsigned w = 0; w < BlockMarks::kWords; w++) {
    if (!nodes[w]) continue;
    const uint64_t bits = marked(w);
    for (unsigned i = 0; i < 8; i++) {
      if (!(bits >> (8 * i) & kAll8)) continue;
      OcTreeNode* const octet = NodeChildren::get(*nodes[w], i);
      if (!octet) continue;
      __builtin_prefetch(octet, 1);
      octets[count++].node = octet;
    }
  }
  for (size_t i = 0; i < count; i++) {
    octets[i].voxels = NodeChildren::of(*octets[i].node);
    __builtin_prefetch(octets[i].voxels);
  }
  for (size_t i = 0; i < count; i++)
    for (unsigned j = 0; octets[i].voxels && j < 8; j++) __builtin_prefetch(octets[i].voxels[j], 1);
  __asm__ volatile("");  // g++ 12 removes calls of functions that only prefetch
}

}  // namespace

CellUpdate::CellUpdate(const octomap::OcTree& tree, bool prunes)
    : hit(tree.getProbHitLog()),
      miss(tree.getProbMissLog()),
      clamp_min(tree.getClampingThresMinLog()),
      clamp_max(tree.getClampingThresMaxLog()),
      prune(prunes) {}

/** Marks of the voxels of a node below a block. */
struct NodeUpdater::Part {
  const uint64_t* free;
  const uint64_t* occupied;
};

NodeUpdater::NodeUpdater(const CellUpdate& update)
    : update_(update),
      new_free_(update.updated(0, update.miss)),
      new_occupied_(update.updated(0, update.hit)) {}

OcTreeNode* NodeUpdater::createChild(OcTreeNode& node, unsigned i) {
  auto& children = NodeChildren::of(node);
  if (!children) children = new AbstractOcTreeNode*[8]();
  auto* const child = new OcTreeNode();
  children[i] = child;
  created_++;
  return child;
}

void NodeUpdater::expand(OcTreeNode& leaf) {
  for (unsigned i = 0; i < 8; i++) createChild(leaf, i)->setValue(leaf.getValue());
}

void NodeUpdater::finish(OcTreeNode& node, bool may_prune) {
  auto& children = NodeChildren::of(node);
  const OcTreeNode* const first = NodeChildren::get(node, 0);
  bool equal = may_prune && first;
  float largest = kLowest;
  for (unsigned i = 0; i < 8; i++) {
    OcTreeNode* const child = NodeChildren::get(node, i);
    if (child && child->getValue() > largest) largest = child->getValue();
    equal =
        equal && child && child->getValue() == first->getValue() && NodeChildren::isLeaf(*child);
  }
  if (!equal) return node.setValue(largest);
  node.setValue(first->getValue());
  for (unsigned i = 0; i < 8; i++) delete static_cast<OcTreeNode*>(children[i]);
  delete[] children;
  children = nullptr;
  created_ -= 8;
}

bool NodeUpdater::changesLeaf(float log_odds, const BlockMarks& marks) const {
  uint64_t free = 0, occupied = 0;
  for (const uint64_t word : marks.free) free |= word;
  for (const uint64_t word : marks.occupied) occupied |= word;
  return (free && update_.changes(log_odds, update_.miss)) ||
         (occupied && update_.changes(log_odds, update_.hit));
}

bool NodeUpdater::updateBlock(OcTreeNode& node, bool is_new, const BlockMarks& marks) {
  prefetchNodes(node, marks);
  return update<BlockMarks::kWords>(node, is_new, {marks.free, marks.occupied});
}

template <unsigned kWords>
bool NodeUpdater::update(OcTreeNode& node, bool is_new, const Part& part) {
  const bool is_leaf = !is_new && NodeChildren::isLeaf(node);
  if (is_leaf || is_new) {
    uint64_t some_free = 0, some_occupied = 0, all_free = ~uint64_t{0}, all_occupied = all_free;
    for (unsigned w = 0; w < kWords; w++) {
      some_free |= part.free[w];
      some_occupied |= part.occupied[w];
      all_free &= part.free[w];
      all_occupied &= part.occupied[w];
    }
    const float old = node.getValue();
    if (is_leaf && !(some_free && update_.changes(old, update_.miss)) &&
        !(some_occupied && update_.changes(old, update_.hit)))
      return false;
    const bool is_free = ~all_free == 0, is_occupied = ~all_occupied == 0;
    if (update_.prune && (is_free || is_occupied)) {
      const float now = is_new ? (is_free ? new_free_ : new_occupied_)
                               : update_.updated(old, is_free ? update_.miss : update_.hit);
      if (!std::isnan(now)) {  // octomap does not prune values that are no numbers
        node.setValue(now);
        return true;
      }
    }
    if (is_leaf) expand(node);
  }
  if (!updateChildren<kWords>(node, part)) return false;
  finish(node, update_.prune);
  return true;
}

template <unsigned kWords>
bool NodeUpdater::updateChildren(OcTreeNode& node, const Part& part) {
  bool changed = false;
  for (unsigned i = 0; i < 8; i++) {
    // A child has the i-th eighth of the words, or of the bits of the only word.
    constexpr unsigned kWordsOfChild = kWords / 8;
    const Part below{part.free + i * kWordsOfChild, part.occupied + i * kWordsOfChild};
    uint64_t marked = 0;
    if constexpr (kWords == 1)
      marked = (*part.free | *part.occupied) >> (8 * i) & kAll8;
    else
      for (unsigned w = 0; w < kWordsOfChild; w++) marked |= below.free[w] | below.occupied[w];
    if (!marked) continue;
    OcTreeNode* child = NodeChildren::get(node, i);
    const bool is_new = !child;
    if (is_new) child = createChild(node, i);
    if constexpr (kWords == 1)
      changed |= updateOctet(*child, is_new, *part.free >> (8 * i) & kAll8,
                             *part.occupied >> (8 * i) & kAll8);
    else
      changed |= update<kWordsOfChild>(*child, is_new, below);
  }
  return changed;
}

/** Updates 8 finest voxels, without branches. A leaf and a new node become 8 values first, and get
 * children only if the values differ. */
bool NodeUpdater::updateOctet(OcTreeNode& node, bool is_new, uint32_t free, uint32_t occupied) {
  auto& children = NodeChildren::of(node);
  std::array<float, 8> values{};
  uint32_t exist = 0;  // bits of the voxels that are known before
  if (children)
    for (unsigned i = 0; i < 8; i++) {
      if (!children[i]) continue;
      exist |= 1U << i;
      values[i] = static_cast<OcTreeNode*>(children[i])->getValue();
    }
  const bool has_children = exist != 0;
  if (!has_children && !is_new) {
    values.fill(node.getValue());
    exist = kAll8;
  }

  // The compiler makes vectors of this loop, if it has neither branches nor shifts.
  constexpr std::array<uint32_t, 8> kBits{1, 2, 4, 8, 16, 32, 64, 128};
  std::array<uint32_t, 8> changed;
  const CellUpdate update = update_;
  for (unsigned i = 0; i < 8; i++) {
    const bool is_hit = (occupied & kBits[i]) != 0, is_free = (free & kBits[i]) != 0;
    const bool is_known = (exist & kBits[i]) != 0;
    const float change = is_hit ? update.hit : update.miss;
    const bool changes = (is_hit | is_free) & (!is_known | update.changes(values[i], change));
    values[i] = changes ? update.updated(values[i], change) : values[i];
    changed[i] = changes ? 1 : 0;
  }
  uint32_t some_changed = 0;
  for (const uint32_t one : changed) some_changed |= one;
  if (!some_changed) return false;

  const uint32_t known = exist | free | occupied;
  bool equal = true;
  for (const float value : values) equal &= value == values[0];
  if (!(update_.prune && equal && known == kAll8)) {
    storeOctet(node, known, values);
    return true;
  }
  if (has_children) {
    for (unsigned i = 0; i < 8; i++) delete static_cast<OcTreeNode*>(children[i]);
    delete[] children;
    children = nullptr;
    created_ -= countBits(exist);
  }
  node.setValue(values[0]);
  return true;
}

void NodeUpdater::storeOctet(OcTreeNode& node, uint32_t exist, const std::array<float, 8>& values) {
  float largest = kLowest;
  for (unsigned i = 0; i < 8; i++) {
    if (!(exist >> i & 1U)) continue;
    OcTreeNode* child = NodeChildren::get(node, i);
    if (!child) child = createChild(node, i);
    child->setValue(values[i]);
    largest = values[i] > largest ? values[i] : largest;
  }
  node.setValue(largest);
}

}  // namespace mrpt::fusion
