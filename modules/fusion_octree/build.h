// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <vector>

#include "fusion_octree/cube.h"
#include "fusion_octree/subtree.h"
#include "fusion_octree/tree_access.h"
#include "fusion_octree/voxel_block.h"

/** \file
 * Builds a whole octomap::OcTree in one traversal, its nodes bottom-up. setNodeValue() would
 * descend from the root for each voxel. Log-odds are stored without clamping.
 */

namespace mrpt::fusion {

/** Content of a cube of the octree under construction. */
struct OcTreeFill {
  /** Kind of content. */
  enum class Kind {
    Unknown,  ///< Unknown space
    Leaf,     ///< One value in the whole cube
    Split,    ///< Content given by the children
    Copy,     ///< Content of a node of another octree, and of all nodes below it
    Block     ///< The voxels of a block, for cubes of VoxelBlock::kDepth
  };
  Kind kind = Kind::Unknown;                  ///< Kind of content
  float log_odds = 0;                         ///< Log-odds of a leaf
  const octomap::OcTreeNode* node = nullptr;  ///< Node to copy
  const VoxelBlock* block = nullptr;          ///< The block. It must stay until the next visit

  /** Makes Kind::Unknown. */
  static OcTreeFill unknown() { return {}; }
  /** Makes Kind::Leaf. */
  static OcTreeFill leaf(float log_odds) { return {Kind::Leaf, log_odds, nullptr, nullptr}; }
  /** Makes Kind::Split. */
  static OcTreeFill split() { return {Kind::Split, 0, nullptr, nullptr}; }
  /** Makes Kind::Copy. The node must be of the depth of the cube, or a leaf. */
  static OcTreeFill copyOf(const octomap::OcTreeNode& node) {
    return {Kind::Copy, 0, &node, nullptr};
  }
  /** Makes Kind::Copy, or Kind::Split if the copy is too much work for one thread. */
  static OcTreeFill copyInParts(const octomap::OcTreeNode& node, const OcTreeCube& cube) {
    constexpr unsigned kWholeCopies = 11;  // depth from which on a copy is small work for a thread
    return cube.depth >= kWholeCopies || !OcTreeAccess::hasChildren(node) ? copyOf(node) : split();
  }
  /** Makes Kind::Block. */
  static OcTreeFill voxels(const VoxelBlock& block) { return {Kind::Block, 0, nullptr, &block}; }

  /** Returns the content as a part of an octree; not for Kind::Split. */
  Subtree subtree(const OcTreeCube& cube) const {
    switch (kind) {
      case Kind::Leaf:
        return Subtree(log_odds);
      case Kind::Copy:
        return Subtree::copyOf(*node, cube.depth);
      case Kind::Block:
        return Subtree::of(*block);
      default:
        return {};
    }
  }
};

namespace detail {

template <class Visitor>
Subtree subtreeOf(const OcTreeCube& cube, typename Visitor::State& state, Visitor& visitor) {
  const OcTreeFill fill = visitor.visit(cube, state);
  if (fill.kind != OcTreeFill::Kind::Split) return fill.subtree(cube);
  Subtree::Children children;
  for (unsigned i = 0; i < 8; i++) {
    const OcTreeCube child = cube.child(i);
    auto child_state = visitor.descend(state, i, child);
    children[i] = subtreeOf(child, child_state, visitor);
  }
  return Subtree::joined(children);
}

}  // namespace detail

/** Fills an empty octree with the contents that \a visitor returns, from the root down.
 *
 * Visitor has a type State, the state of the traversal in a cube, and the functions
 *  - `OcTreeFill visit(const OcTreeCube&, State&)`: returns the content of a cube (never Split at
 * the finest depth);
 *  - `State descend(const State&, unsigned i, const OcTreeCube& child)`: returns the state of the
 * i-th child.
 *
 * Equal siblings are pruned. Inner nodes hold the maximum of their children, as in OctoMap.
 * \param[in,out] tree An empty octree. Its resolution and sensor model do not change.
 * \param[in] root_state The visitor's state for the root.
 * \param[in,out] visitor The visitor.
 */
template <class Visitor>
void buildOcTree(octomap::OcTree& tree, typename Visitor::State root_state, Visitor& visitor) {
  detail::subtreeOf(OcTreeCube{}, root_state, visitor).moveInto(tree);
}

namespace detail {

/** Calls `f(cube, state)` for the known cubes at a depth, except for cubes in a larger leaf, in the
 * order of the octree. */
template <class Visitor, class F>
void forEachCubeAt(unsigned depth, const OcTreeCube& cube, typename Visitor::State& state,
                   Visitor& visitor, F&& f) {
  if (cube.depth == depth) return f(cube, state);
  if (visitor.visit(cube, state).kind != OcTreeFill::Kind::Split) return;
  for (unsigned i = 0; i < 8; i++) {
    const OcTreeCube child = cube.child(i);
    auto child_state = visitor.descend(state, i, child);
    forEachCubeAt(depth, child, child_state, visitor, f);
  }
}

/** Builds the octree above a depth. The contents of the cubes at this depth are in \a built, in the
 * order of the octree. */
template <class Visitor>
Subtree subtreeAbove(unsigned depth, const OcTreeCube& cube, typename Visitor::State& state,
                     Visitor& visitor, std::vector<Subtree>::iterator& built) {
  const OcTreeFill fill = visitor.visit(cube, state);
  if (fill.kind != OcTreeFill::Kind::Split) return fill.subtree(cube);
  Subtree::Children children;
  for (unsigned i = 0; i < 8; i++) {
    const OcTreeCube child = cube.child(i);
    if (child.depth == depth) {
      children[i] = std::move(*built++);
      continue;
    }
    auto child_state = visitor.descend(state, i, child);
    children[i] = subtreeAbove(depth, child, child_state, visitor, built);
  }
  return Subtree::joined(children);
}

}  // namespace detail

/** Builds the same octree as buildOcTree() on all cores. The visitor must be copyable, and have the
 * function
 *  - `State rootState()`: returns the state of the root for this copy of the visitor. */
template <class Visitor>
void buildOcTreeInParallel(octomap::OcTree& tree, const Visitor& visitor) {
  constexpr size_t kEnough = 64;  // number of cubes: some are empty, some are full
  constexpr unsigned kDeepest = 12;
  std::vector<OcTreeCube> cubes;
  unsigned depth = 0;
  while (cubes.size() < kEnough && depth < kDeepest) {
    depth++;
    cubes.clear();
    Visitor own(visitor);
    auto root = own.rootState();
    detail::forEachCubeAt(depth, {}, root, own,
                          [&](const OcTreeCube& c, const auto&) { cubes.push_back(c); });
  }
  std::vector<Subtree> built(cubes.size());
  tbb::parallel_for(size_t{0}, cubes.size(), [&](size_t k) {
    Visitor own(visitor);
    const auto descend = [&](const auto& self, const OcTreeCube& cube, auto& state) -> void {
      if (cube.depth == depth) {
        built[k] = detail::subtreeOf(cube, state, own);
        return;
      }
      unsigned i = 0;
      while (!cube.child(i).contains(cubes[k])) i++;
      const OcTreeCube child = cube.child(i);
      auto child_state = own.descend(state, i, child);
      self(self, child, child_state);
    };
    auto root = own.rootState();
    descend(descend, {}, root);
  });
  Visitor own(visitor);
  auto root = own.rootState();
  auto next = built.begin();
  detail::subtreeAbove(depth, {}, root, own, next).moveInto(tree);
}

}  // namespace mrpt::fusion
