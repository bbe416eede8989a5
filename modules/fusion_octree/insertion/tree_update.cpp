// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Updates an octree from the marks of a scan.
 *
 * First the nodes of all blocks are found or created, from the root down. Then the blocks are
 * updated in parallel: they share no node. Last, the nodes above the blocks get their values. */

#include "fusion_octree/insertion/tree_update.h"

#include <algorithm>
#include <atomic>

#include "fusion_base/parallel.h"
#include "fusion_octree/build.h"
#include "fusion_octree/insertion/node_update.h"

namespace mrpt::fusion {
namespace {

using octomap::OcTreeKey;
using octomap::OcTreeNode;
using Block = TreeUpdater::Block;

constexpr size_t kBlocksPerTask = 8;

/** Returns the place of a block in the octree's order. */
uint64_t orderOf(const OcTreeKey& key) {
  uint64_t order = 0;
  for (unsigned bit = CellWindow::kBlockBits; bit < OcTreeCube::kMaxDepth; bit++)
    for (unsigned axis = 0; axis < 3; axis++)
      order |= static_cast<uint64_t>(key[axis] >> bit & 1U) << (3 * bit + axis);
  return order;
}

/** Calls f(child, first, last) for each child of a node that has blocks. */
template <class F>
void forEachChildWithBlocks(unsigned depth, Block* first, Block* last, F&& f) {
  while (first != last) {
    const auto child =
        octomap::computeChildIdx(first->key, static_cast<int>(OcTreeCube::kMaxDepth - 1 - depth));
    Block* next = first;
    while (next != last &&
           octomap::computeChildIdx(next->key,
                                    static_cast<int>(OcTreeCube::kMaxDepth - 1 - depth)) == child)
      next++;
    f(child, first, next);
    first = next;
  }
}

/** The nodes above the blocks. */
class UpperNodes {
 public:
  UpperNodes(NodeUpdater& updater, const std::vector<Block>& blocks,
             const std::vector<BlockMarks>& marks, bool prune)
      : updater_(updater), blocks_(blocks), marks_(marks), prune_(prune) {}

  /** Finds or creates the nodes of blocks, below a node. */
  void descend(OcTreeNode& node, bool is_new, unsigned depth, Block* first, Block* last) {
    if (depth == CellWindow::kBlockDepth) {
      first->node = &node;
      first->is_new = is_new;
      return;
    }
    if (!is_new && NodeChildren::isLeaf(node)) {
      if (std::none_of(first, last, [&](const Block& b) {
            return updater_.changesLeaf(node.getValue(), marks_[indexOf(b)]);
          }))
        return;
      updater_.expand(node);
    }
    forEachChildWithBlocks(depth, first, last, [&](unsigned i, Block* begin, Block* end) {
      OcTreeNode* child = NodeChildren::get(node, i);
      const bool child_is_new = !child;
      if (child_is_new) child = updater_.createChild(node, i);
      descend(*child, child_is_new, depth + 1, begin, end);
    });
  }

  /** Computes the values of nodes with changed blocks. octomap never prunes the root. \return
   * Whether a block below the node has changed. */
  bool finish(OcTreeNode& node, unsigned depth, Block* first, Block* last) {
    if (depth == CellWindow::kBlockDepth) return first->changed;
    if (NodeChildren::isLeaf(node)) return false;
    bool changed = false;
    forEachChildWithBlocks(depth, first, last, [&](unsigned i, Block* begin, Block* end) {
      changed |= finish(*NodeChildren::get(node, i), depth + 1, begin, end);
    });
    if (changed) updater_.finish(node, prune_ && depth > 0);
    return changed;
  }

 private:
  size_t indexOf(const Block& block) const { return static_cast<size_t>(&block - blocks_.data()); }

  NodeUpdater& updater_;
  const std::vector<Block>& blocks_;
  const std::vector<BlockMarks>& marks_;
  bool prune_;
};

}  // namespace

void TreeUpdater::listBlocks(const CellWindow& window, const std::vector<const CellMarks*>& marks) {
  blocks_.clear();
  for (size_t part = 0; part < marks.size(); part++)
    for (const uint64_t number : marks[part]->numbers()) {
      if (std::any_of(marks.begin(), marks.begin() + static_cast<std::ptrdiff_t>(part),
                      [&](const CellMarks* before) { return before->find(number) != nullptr; }))
        continue;
      const CellKey low = window.lowestOf(number);
      const auto key = [&](unsigned axis) { return static_cast<octomap::key_type>(low[axis]); };
      Block block;
      block.key = OcTreeKey(key(0), key(1), key(2));
      block.order = orderOf(block.key);
      block.number = number;
      blocks_.push_back(block);
    }
  std::sort(blocks_.begin(), blocks_.end(),
            [](const Block& a, const Block& b) { return a.order < b.order; });

  if (marks_.size() < blocks_.size()) marks_.resize(blocks_.size());
  forEachIndex(blocks_.size(), kBlocksPerTask, [&](size_t i) {
    BlockMarks& all = marks_[i];
    all = BlockMarks{};
    for (const CellMarks* const part : marks)
      if (const BlockMarks* const some = part->find(blocks_[i].number))
        for (unsigned w = 0; w < BlockMarks::kWords; w++) {
          all.free[w] |= some->free[w];
          all.occupied[w] |= some->occupied[w];
        }
    for (unsigned w = 0; w < BlockMarks::kWords; w++) all.free[w] &= ~all.occupied[w];
  });
}

void TreeUpdater::update(octomap::OcTree& tree, const CellWindow& window,
                         const std::vector<const CellMarks*>& marks, bool prune) {
  listBlocks(window, marks);
  if (blocks_.empty()) return;
  const bool is_new = !tree.getRoot();
  if (is_new) OcTreeAccess::createRoot(tree);

  const CellUpdate update(tree, prune);
  NodeUpdater updater(update);
  UpperNodes upper(updater, blocks_, marks_, prune);
  Block* const first = blocks_.data();
  Block* const last = first + blocks_.size();
  upper.descend(*tree.getRoot(), is_new, 0, first, last);
  std::atomic<int64_t> created{0};
  forEachRange(blocks_.size(), kBlocksPerTask, [&](size_t begin, size_t end) {
    NodeUpdater own(update);
    for (size_t i = begin; i != end; i++)
      if (Block& b = blocks_[i]; b.node) b.changed = own.updateBlock(*b.node, b.is_new, marks_[i]);
    created += own.created();
  });
  upper.finish(*tree.getRoot(), 0, first, last);
  OcTreeAccess::addNodes(tree, updater.created() + created);
}

}  // namespace mrpt::fusion
