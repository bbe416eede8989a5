// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>
#include <tbb/parallel_for.h>

#include <cstdint>
#include <memory>
#include <vector>

/** \file
 * Builds a whole octomap::OcTree top-down in one traversal. setNodeValue() would descend from the
 * root for each voxel. Log-odds are stored without clamping.
 */

namespace mrpt::fusion {

/** A cube of an octree's grid, by the key of its lowest finest voxel and its depth. */
struct OcTreeCube {
  octomap::OcTreeKey key{0, 0, 0};  ///< Key of the lowest finest voxel
  unsigned depth = 0;               ///< Depth: 0 is the root, 16 is a finest voxel

  static constexpr unsigned kMaxDepth = 16;  ///< Depth of the finest voxels

  /** Returns the side, finest voxels. */
  uint32_t side() const { return 1U << (kMaxDepth - depth); }

  /** True if the other cube is this cube or lies within it. */
  bool contains(const OcTreeCube& o) const {
    if (o.depth < depth) return false;
    for (unsigned axis = 0; axis < 3; axis++)
      if ((key[axis] ^ o.key[axis]) >> (kMaxDepth - depth)) return false;
    return true;
  }

  /** Returns the i-th of 8 children, in OctoMap's order (bit 0: x, bit 1: y, bit 2: z). */
  OcTreeCube child(unsigned i) const {
    const unsigned height = kMaxDepth - depth - 1;
    const auto part = [&](unsigned axis) {
      return static_cast<octomap::key_type>(key[axis] + ((i >> axis & 1U) << height));
    };
    return {{part(0), part(1), part(2)}, depth + 1};
  }
};

/** Returns the node of the i-th child cube of a node's cube, for traversals deeper than the octree.
 * A leaf counts as all cubes in it: for a leaf the function returns the leaf itself.
 * \param[in] tree The octree of the node.
 * \param[in] node The node; null if its cube is unknown.
 * \param[in] i Number of the child in OctoMap's order.
 * \return Null if the child's cube is unknown. */
inline const octomap::OcTreeNode* childOrSelf(const octomap::OcTree& tree,
                                              const octomap::OcTreeNode* node, unsigned i) {
  if (!node || !tree.nodeHasChildren(node)) return node;
  return tree.nodeChildExists(node, i) ? tree.getNodeChild(node, i) : nullptr;
}

/** Content of a cube of the octree under construction. */
struct OcTreeFill {
  /** Kind of content. */
  enum class Kind {
    Unknown,  ///< Unknown space
    Leaf,     ///< One value in the whole cube
    Split     ///< Content given by the children
  };
  Kind kind = Kind::Unknown;  ///< Kind of content
  float log_odds = 0;         ///< Log-odds of a leaf

  static OcTreeFill unknown() { return {}; }  ///< Makes Kind::Unknown
  static OcTreeFill leaf(float log_odds) { return {Kind::Leaf, log_odds}; }  ///< Makes Kind::Leaf
  static OcTreeFill split() { return {Kind::Split, 0}; }                     ///< Makes Kind::Split
};

/** Access to protected members of octomap::OcTree: root, and log-odds of the sensor model. */
class OcTreeAccess : private octomap::OcTree {
 public:
  /** Creates the root node of an empty octree. */
  static octomap::OcTreeNode* createRoot(octomap::OcTree& tree) {
    tree.*(&OcTreeAccess::root) = new octomap::OcTreeNode();
    tree.*(&OcTreeAccess::tree_size) = 1;
    tree.*(&OcTreeAccess::size_changed) = true;
    return tree.getRoot();
  }

  /** Counts nodes that were created or, if \a count is negative, deleted. */
  static void addNodes(octomap::OcTree& tree, int64_t count) {
    tree.*(&OcTreeAccess::tree_size) += static_cast<size_t>(count);
    tree.*(&OcTreeAccess::size_changed) = true;
  }

  /** Returns whether an octree records which voxels change. */
  static bool recordsChanges(const octomap::OcTree& tree) {
    return tree.*(&OcTreeAccess::use_change_detection);
  }

  /** Moves the octree \a child below a node, as its i-th child. The node must not have this child.
   * \a child becomes empty. */
  static void adoptChild(octomap::OcTree& tree, octomap::OcTreeNode& node, unsigned i,
                         octomap::OcTree& child) {
    struct Node : octomap::OcTreeNode {
      static octomap::AbstractOcTreeNode**& childrenOf(octomap::OcTreeNode& n) {
        return n.*(&Node::children);
      }
    };
    tree.createNodeChild(&node, i);  // allocates the children, and counts one node
    octomap::AbstractOcTreeNode*& slot = Node::childrenOf(node)[i];
    delete static_cast<octomap::OcTreeNode*>(slot);
    slot = child.getRoot();
    tree.*(&OcTreeAccess::tree_size) += child.size() - 1;
    child.*(&OcTreeAccess::root) = nullptr;
    child.*(&OcTreeAccess::tree_size) = 0;
    child.*(&OcTreeAccess::size_changed) = true;
  }

  /** The 5 log-odds of the sensor model, bit for bit. OctoMap's setters take probabilities and
   * round. */
  struct SensorModel {
    float clamp_min;            ///< Lowest log-odds of a voxel
    float clamp_max;            ///< Highest log-odds of a voxel
    float hit;                  ///< Change by a hit, log-odds
    float miss;                 ///< Change by a miss, log-odds
    float occupancy_threshold;  ///< Least log-odds of an occupied voxel
  };
  /** Returns the sensor model of an octree. */
  static SensorModel sensorModel(const octomap::OcTree& t) {
    return {t.getClampingThresMinLog(), t.getClampingThresMaxLog(), t.getProbHitLog(),
            t.getProbMissLog(), t.getOccupancyThresLog()};
  }
  /** Sets the sensor model of an octree. The voxels do not change. */
  static void setSensorModel(octomap::OcTree& t, const SensorModel& m) {
    t.*(&OcTreeAccess::clamping_thres_min) = m.clamp_min;
    t.*(&OcTreeAccess::clamping_thres_max) = m.clamp_max;
    t.*(&OcTreeAccess::prob_hit_log) = m.hit;
    t.*(&OcTreeAccess::prob_miss_log) = m.miss;
    t.*(&OcTreeAccess::occ_prob_thres_log) = m.occupancy_threshold;
  }
};

namespace detail {

/** A node that is created together with its ancestors, at the first known cube in its cube. */
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
  detail::LazyNode root{tree, nullptr, 0};
  detail::buildOcTreeNode(root, OcTreeCube{}, root_state, visitor);
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

/** Builds the octree above a depth. The octrees of the cubes at this depth are in \a built, in the
 * order of the octree. */
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
