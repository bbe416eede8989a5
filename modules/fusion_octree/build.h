// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>
#include <tbb/parallel_for.h>

#include <cstdint>
#include <memory>
#include <vector>

/** \file
 * Building a whole octomap::OcTree top-down in one traversal, instead of one setNodeValue() from
 * the root per voxel. Log-odds are stored as given: nothing is clamped.
 */

namespace mrpt::fusion {

/** A cube of an octree's grid: its lowest-corner key at the finest level, and its depth
 * (0: the root's cube, 16: a finest voxel). */
struct OcTreeCube {
  octomap::OcTreeKey key{0, 0, 0};  ///< of its lowest finest voxel
  unsigned depth = 0;               ///< 0: the root's

  static constexpr unsigned kMaxDepth = 16;  ///< of the finest voxels

  /** Side in finest voxels. */
  uint32_t side() const { return 1U << (kMaxDepth - depth); }

  /** True if the other cube is this one or lies within it. */
  bool contains(const OcTreeCube& o) const {
    if (o.depth < depth) return false;
    for (unsigned axis = 0; axis < 3; axis++)
      if ((key[axis] ^ o.key[axis]) >> (kMaxDepth - depth)) return false;
    return true;
  }

  /** The i-th of eight children, in OctoMap's order (bit 0: x, bit 1: y, bit 2: z). */
  OcTreeCube child(unsigned i) const {
    const unsigned height = kMaxDepth - depth - 1;
    const auto part = [&](unsigned axis) {
      return static_cast<octomap::key_type>(key[axis] + ((i >> axis & 1U) << height));
    };
    return {{part(0), part(1), part(2)}, depth + 1};
  }
};

/** The node of the i-th child cube of a node's cube, for walks that go deeper than this tree does:
 * a leaf, pruned or not, stands for all the cubes below it, and is returned itself.
 * \param[in] tree The node's. \param[in] node Null if nothing is known of its cube.
 * \param[in] i In OctoMap's order. \return Null if nothing is known of the child's. */
inline const octomap::OcTreeNode* childOrSelf(const octomap::OcTree& tree,
                                              const octomap::OcTreeNode* node, unsigned i) {
  if (!node || !tree.nodeHasChildren(node)) return node;
  return tree.nodeChildExists(node, i) ? tree.getNodeChild(node, i) : nullptr;
}

/** What a cube of the tree under construction holds. */
struct OcTreeFill {
  /** The three things that a cube can be. */
  enum class Kind {
    Unknown,  ///< nothing is known of it
    Leaf,     ///< one value in all of it
    Split     ///< its children tell
  };
  Kind kind = Kind::Unknown;  ///< what the cube is
  float log_odds = 0;         ///< of a leaf

  static OcTreeFill unknown() { return {}; }                                 ///< Kind::Unknown
  static OcTreeFill leaf(float log_odds) { return {Kind::Leaf, log_odds}; }  ///< Kind::Leaf
  static OcTreeFill split() { return {Kind::Split, 0}; }                     ///< Kind::Split
};

/** Reaches what octomap::OcTree keeps protected: its root and its sensor model's log-odds. */
class OcTreeAccess : private octomap::OcTree {
 public:
  /** Gives an empty tree its root node. */
  static octomap::OcTreeNode* createRoot(octomap::OcTree& tree) {
    tree.*(&OcTreeAccess::root) = new octomap::OcTreeNode();
    tree.*(&OcTreeAccess::tree_size) = 1;
    tree.*(&OcTreeAccess::size_changed) = true;
    return tree.getRoot();
  }

  /** Makes all of a tree, which becomes empty, the i-th child of a node that has no such child. */
  static void adoptChild(octomap::OcTree& tree, octomap::OcTreeNode& node, unsigned i,
                         octomap::OcTree& child) {
    struct Node : octomap::OcTreeNode {
      static octomap::AbstractOcTreeNode**& childrenOf(octomap::OcTreeNode& n) {
        return n.*(&Node::children);
      }
    };
    tree.createNodeChild(&node, i);  // gives the node its children, and the tree one node more
    octomap::AbstractOcTreeNode*& slot = Node::childrenOf(node)[i];
    delete static_cast<octomap::OcTreeNode*>(slot);
    slot = child.getRoot();
    tree.*(&OcTreeAccess::tree_size) += child.size() - 1;
    child.*(&OcTreeAccess::root) = nullptr;
    child.*(&OcTreeAccess::tree_size) = 0;
    child.*(&OcTreeAccess::size_changed) = true;
  }

  /** The five log-odds of the sensor model, bit for bit (OctoMap's setters take probabilities and
   * round). */
  struct SensorModel {
    float clamp_min;            ///< lowest value that a voxel can reach
    float clamp_max;            ///< highest value that a voxel can reach
    float hit;                  ///< added by a hit
    float miss;                 ///< added by a miss
    float occupancy_threshold;  ///< voxels from here on are occupied
  };
  /** The model of a tree. */
  static SensorModel sensorModel(const octomap::OcTree& t) {
    return {t.getClampingThresMinLog(), t.getClampingThresMaxLog(), t.getProbHitLog(),
            t.getProbMissLog(), t.getOccupancyThresLog()};
  }
  /** Gives a tree another model; its voxels stay as they are. */
  static void setSensorModel(octomap::OcTree& t, const SensorModel& m) {
    t.*(&OcTreeAccess::clamping_thres_min) = m.clamp_min;
    t.*(&OcTreeAccess::clamping_thres_max) = m.clamp_max;
    t.*(&OcTreeAccess::prob_hit_log) = m.hit;
    t.*(&OcTreeAccess::prob_miss_log) = m.miss;
    t.*(&OcTreeAccess::occ_prob_thres_log) = m.occupancy_threshold;
  }
};

namespace detail {

/** A node that is created, with its ancestors, when the first known cube below it is found. */
struct LazyNode {
  octomap::OcTree& tree;
  LazyNode* parent;
  unsigned index;
  octomap::OcTreeNode* node = nullptr;

  octomap::OcTreeNode* get() {
    if (!node)
      node = parent ? tree.createNodeChild(parent->get(), index) : OcTreeAccess::createRoot(tree);
    return node;
  }
};

template <class Visitor>
void buildOcTreeNode(LazyNode& self, const OcTreeCube& cube, typename Visitor::State& state,
                     Visitor& visitor) {
  const OcTreeFill fill = visitor.visit(cube, state);
  if (fill.kind == OcTreeFill::Kind::Unknown) return;
  if (fill.kind == OcTreeFill::Kind::Leaf) {
    self.get()->setLogOdds(fill.log_odds);
    return;
  }
  for (unsigned i = 0; i < 8; i++) {
    LazyNode child{self.tree, &self, i};
    const OcTreeCube child_cube = cube.child(i);
    auto child_state = visitor.descend(state, i, child_cube);
    buildOcTreeNode(child, child_cube, child_state, visitor);
  }
  if (self.node && !self.tree.pruneNode(self.node)) self.node->updateOccupancyChildren();
}

}  // namespace detail

/** Fills an empty tree by asking \a visitor what each cube holds, from the root down.
 *
 * Visitor has a type State (what it knows of a cube), and
 *  - `OcTreeFill visit(const OcTreeCube&, State&)`: unknown, one value, or split (never at the
 *    finest depth);
 *  - `State descend(const State&, unsigned i, const OcTreeCube& child)`: state of the i-th child.
 *
 * Equal siblings are pruned and inner nodes hold their children's maximum, as OctoMap keeps them.
 * \param[in,out] tree An empty tree; its resolution and sensor model are not touched.
 * \param[in] root_state The visitor's state for the root. \param[in,out] visitor As above.
 */
template <class Visitor>
void buildOcTree(octomap::OcTree& tree, typename Visitor::State root_state, Visitor& visitor) {
  detail::LazyNode root{tree, nullptr, 0};
  detail::buildOcTreeNode(root, OcTreeCube{}, root_state, visitor);
}

namespace detail {

/** Calls `f(cube, state)` for the known cubes at a depth that are not part of a larger leaf, in the
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

/** The tree down to a depth, whose cubes are built already: \a built, in the order of the octree.
 */
template <class Visitor>
void buildAbove(unsigned depth, LazyNode& self, const OcTreeCube& cube,
                typename Visitor::State& state, Visitor& visitor,
                std::vector<std::unique_ptr<octomap::OcTree>>::iterator& built) {
  const OcTreeFill fill = visitor.visit(cube, state);
  if (fill.kind == OcTreeFill::Kind::Leaf) self.get()->setLogOdds(fill.log_odds);
  if (fill.kind != OcTreeFill::Kind::Split) return;
  for (unsigned i = 0; i < 8; i++) {
    const OcTreeCube child_cube = cube.child(i);
    if (child_cube.depth == depth) {
      octomap::OcTree& child = **built++;
      if (child.getRoot()) OcTreeAccess::adoptChild(self.tree, *self.get(), i, child);
      continue;
    }
    LazyNode child{self.tree, &self, i};
    auto child_state = visitor.descend(state, i, child_cube);
    buildAbove(depth, child, child_cube, child_state, visitor, built);
  }
  if (self.node && !self.tree.pruneNode(self.node)) self.node->updateOccupancyChildren();
}

}  // namespace detail

/** buildOcTree() on all cores: the same tree, for a visitor that can be copied and has
 *  - `State rootState()`: that of the root, for this copy of the visitor. */
template <class Visitor>
void buildOcTreeInParallel(octomap::OcTree& tree, const Visitor& visitor) {
  constexpr size_t kEnough = 64;  // cubes, for some are empty and some full
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
  std::vector<std::unique_ptr<octomap::OcTree>> built(cubes.size());
  tbb::parallel_for(size_t{0}, cubes.size(), [&](size_t k) {
    built[k] = std::make_unique<octomap::OcTree>(tree.getResolution());
    Visitor own(visitor);
    const auto descend = [&](const auto& self, const OcTreeCube& cube, auto& state) -> void {
      if (cube.depth == depth) {
        detail::LazyNode root{*built[k], nullptr, 0};
        return detail::buildOcTreeNode(root, cube, state, own);
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
  detail::LazyNode node{tree, nullptr, 0};
  auto next = built.begin();
  detail::buildAbove(depth, node, {}, root, own, next);
}

}  // namespace mrpt::fusion
