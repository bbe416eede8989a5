// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Combines octrees in one traversal of all. */
#include "fusion_team/ledger/fused_blocks.h"

#include <algorithm>
#include <utility>

namespace mrpt::fusion {
namespace {
using octomap::OcTree;
using octomap::OcTreeNode;

/** A node of one of the maps that covers a cube, or is larger. */
struct MapNode {
  const OcTree* map;
  const OcTreeNode* node;
  bool counts;  // false if the map only fills unknown space
};

class CombiningVisitor {
 public:
  /** Nodes of the maps in a cube, and the node of the earlier result. The nodes are a range at the
   * top of a stack that all states share. States live in the order of the recursion. */
  class State {
   public:
    State(std::vector<MapNode>& stack, const OcTreeNode* earlier, TouchedSpace::Share share)
        : before(earlier),
          touched(share),
          stack_(&stack),
          begin_(stack.size()),
          end_(stack.size()) {}
    State(State&& o) noexcept
        : before(o.before),
          touched(o.touched),
          stack_(std::exchange(o.stack_, nullptr)),
          begin_(o.begin_),
          end_(o.end_) {}
    State& operator=(State&&) = delete;
    ~State() {
      if (stack_) stack_->resize(begin_, MapNode{nullptr, nullptr, false});
    }

    void add(const MapNode& n) {
      stack_->push_back(n);
      end_++;
    }
    size_t size() const { return end_ - begin_; }
    const MapNode& operator[](size_t i) const { return (*stack_)[begin_ + i]; }

    const OcTreeNode* before;     // null where the earlier result is unknown or not needed
    TouchedSpace::Share touched;  // share of the cube to compute

   private:
    std::vector<MapNode>* stack_;
    size_t begin_, end_;
  };

  CombiningVisitor(const std::vector<std::shared_ptr<const OcTree>>& maps, size_t counting,
                   const MergeParams& params, const OcTreeAccess::SensorModel& model,
                   const OcTree& before, const TouchedSpace& touched)
      : maps_(maps),
        counting_(counting),
        params_(params),
        model_(model),
        before_(before),
        touched_(touched) {}

  State rootState() {
    State s(stack_, before_.getRoot(), shareOf({}, before_.getRoot()));
    if (s.touched != TouchedSpace::Share::None)
      for (size_t k = 0; k < maps_.size(); k++)
        if (const auto* root = maps_[k]->getRoot()) s.add({maps_[k].get(), root, k < counting_});
    return s;
  }

  State descend(const State& parent, unsigned i, const OcTreeCube& cube) {
    if (parent.touched == TouchedSpace::Share::None)
      return {stack_, childOrSelf(before_, parent.before, i), TouchedSpace::Share::None};
    const OcTreeNode* before = nullptr;
    auto touched = parent.touched;
    if (touched == TouchedSpace::Share::Part) {
      before = childOrSelf(before_, parent.before, i);
      touched = shareOf(cube, before);
    }
    State s(stack_, before, touched);
    if (touched == TouchedSpace::Share::None) return s;
    for (size_t k = 0; k < parent.size(); k++) {
      const auto [map, node, counts] = parent[k];
      if (const auto* child = childOrSelf(*map, node, i)) s.add({map, child, counts});
    }
    return s;
  }

  OcTreeFill visit(const OcTreeCube& cube, const State& s) {
    if (s.touched == TouchedSpace::Share::Part) return OcTreeFill::split();
    if (s.touched == TouchedSpace::Share::None) return copyOf(s.before, cube);
    if (s.size() == 0) return OcTreeFill::unknown();
    if (s.size() == 1) return copyOf(s[0].node, cube);
    // Maps that fill unknown space come last.
    size_t n = s.size();
    while (n > 1 && !s[n - 1].counts) n--;
    bool is_leaf = true;
    for (size_t k = 0; k < n; k++) is_leaf = is_leaf && !OcTreeAccess::hasChildren(*s[k].node);
    if (is_leaf) {
      values_.clear();
      for (size_t k = 0; k < n; k++) values_.push_back(s[k].node->getLogOdds());
      return OcTreeFill::leaf(combined());
    }
    if (cube.depth < VoxelBlock::kDepth) return OcTreeFill::split();
    combineBlock(s);
    return OcTreeFill::voxels(block_);
  }

 private:
  /** Returns the content of a node; null for unknown space. */
  static OcTreeFill copyOf(const OcTreeNode* node, const OcTreeCube& cube) {
    return node ? OcTreeFill::copyInParts(*node, cube) : OcTreeFill::unknown();
  }

  float combined() const {
    return combineLogOdds(values_.data(), values_.size(), params_, model_.clamp_min,
                          model_.clamp_max);
  }

  /** Combines the voxels of a block. */
  void combineBlock(const State& s) {
    sources_.resize(std::max(sources_.size(), s.size()));
    for (size_t k = 0; k < s.size(); k++) {
      sources_[k].known = 0;
      sources_[k].add(*s[k].node);
    }
    block_.known = 0;
    for (unsigned i = 0; i < VoxelBlock::kVoxels; i++) {
      values_.clear();
      for (size_t k = 0; k < s.size() && (s[k].counts || values_.empty()); k++)
        if (sources_[k].isKnown(i)) values_.push_back(sources_[k].value[i]);
      if (!values_.empty()) block_.set(i, combined());
    }
  }

  /** Returns the share of a cube to compute. A leaf with the value 0 that spans blocks is computed
   * as a whole: pruning takes 0 and -0 for equal, so that the leaf does not tell the bits of its
   * blocks. */
  TouchedSpace::Share shareOf(const OcTreeCube& cube, const OcTreeNode* before) const {
    const auto share = touched_.shareOf(cube);
    if (share == TouchedSpace::Share::Part && before && !before_.nodeHasChildren(before) &&
        before->getLogOdds() == 0)
      return TouchedSpace::Share::All;
    return share;
  }

  const std::vector<std::shared_ptr<const OcTree>>& maps_;
  size_t counting_;
  const MergeParams& params_;
  const OcTreeAccess::SensorModel& model_;
  const OcTree& before_;
  const TouchedSpace& touched_;
  std::vector<MapNode> stack_;
  std::vector<float> values_;
  std::vector<VoxelBlock> sources_;
  VoxelBlock block_;
};

}  // namespace

float combineLogOdds(const float* values, size_t n, const MergeParams& params, float clamp_min,
                     float clamp_max) {
  if (n == 1 || params.policy == MergePolicy::Stitch) return values[0];
  if (params.policy == MergePolicy::Bayes && n > 2) {
    // One after the other in one number of 64 bits: the order of the maps gives the bits.
    double sum = 0;
    float low = clamp_min, high = clamp_max;
    for (size_t i = 0; i < n; i++) {
      sum += values[i];
      low = std::min(low, values[i]);
      high = std::max(high, values[i]);
    }
    return static_cast<float>(std::clamp(sum, static_cast<double>(low), static_cast<double>(high)));
  }
  float fused = values[0];
  for (size_t i = 1; i < n; i++)
    fused = fuseLogOdds(fused, values[i], params, clamp_min, clamp_max);
  return fused;
}

std::unique_ptr<OcTree> combineOcTrees(const std::vector<std::shared_ptr<const OcTree>>& maps,
                                       size_t counting, const MergeParams& params,
                                       const OcTreeAccess::SensorModel& model, const OcTree& before,
                                       const TouchedSpace& touched) {
  auto fused = std::make_unique<OcTree>(maps.front()->getResolution());
  OcTreeAccess::setSensorModel(*fused, model);
  buildOcTreeInParallel(*fused, CombiningVisitor(maps, counting, params, model, before, touched));
  return fused;
}

}  // namespace mrpt::fusion
