// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "fusion_octree/build.h"

/** \file
 * The twin of transformOcTree(): an octree that is built node by node from the root down, with one
 * search in the source for each voxel. It says which bits the result must have. */

namespace map_tests::reference {

using mrpt::fusion::OcTreeAccess;
using mrpt::fusion::OcTreeCube;
using mrpt::fusion::OcTreeFill;
using octomap::OcTree;
using octomap::OcTreeKey;
using octomap::OcTreeNode;

constexpr double kGridSide = 65536.0;
constexpr double kGridOrigin = 32768.0;

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
void build(LazyNode& self, const OcTreeCube& cube, typename Visitor::State& state,
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
    build(child, child_cube, child_state, visitor);
  }
  if (self.node && !self.tree.pruneNode(self.node)) self.node->updateOccupancyChildren();
}

/** Builds an octree as buildOcTree() does. */
template <class Visitor>
std::unique_ptr<OcTree> built(double resolution, const OcTreeAccess::SensorModel& model,
                              typename Visitor::State root_state, Visitor& visitor) {
  auto tree = std::make_unique<OcTree>(resolution);
  OcTreeAccess::setSensorModel(*tree, model);
  LazyNode root{*tree, nullptr, 0};
  build(root, OcTreeCube{}, root_state, visitor);
  return tree;
}

/** A piece of the source's known space: a node with its cube. */
struct Piece {
  const OcTreeNode* node;
  OcTreeCube cube;
};

/** Axis-aligned box in the source grid's units (voxels, from its lowest corner). */
struct Box {
  Eigen::Vector3d low, high;

  double volumeIn(const OcTreeCube& c) const {
    double v = 1;
    for (unsigned axis = 0; axis < 3; axis++) {
      const double k = c.key[axis];
      v *= std::max(0.0, std::min(high[axis], k + c.side()) - std::max(low[axis], k));
    }
    return v;
  }
};

/** Returns the content of a cube of the new grid, from the pieces of the source that overlap it. */
class ResamplingVisitor {
 public:
  /** The pieces that overlap a cube: a few pieces of about its size. They are a range at the top of
   * a stack that all states share. States live in the order of the recursion. */
  class State {
   public:
    explicit State(std::vector<Piece>& stack)
        : stack_(&stack), begin_(stack.size()), end_(begin_) {}
    State(State&& o) noexcept
        : stack_(o.stack_), begin_(o.begin_), end_(o.end_), owns_(std::exchange(o.owns_, false)) {}
    ~State() {
      if (owns_) stack_->resize(begin_);
    }

    /** Returns a state with the same pieces. It is valid as long as this state. */
    State view() const {
      State s(*stack_);
      s.begin_ = begin_;
      s.end_ = end_;
      s.owns_ = false;
      return s;
    }

    void add(const Piece& p) {
      stack_->push_back(p);
      end_++;
    }
    size_t size() const { return end_ - begin_; }
    const Piece& operator[](size_t i) const { return (*stack_)[begin_ + i]; }

   private:
    std::vector<Piece>* stack_;
    size_t begin_, end_;
    bool owns_ = true;
  };

  ResamplingVisitor(const OcTree& source, const Eigen::Isometry3d& T_src_dst, double resolution)
      : source_(source) {
    // From voxel units of the new grid to voxel units of the source grid.
    scale_ = resolution / source.getResolution();
    rotation_ = T_src_dst.linear();
    translation_ = T_src_dst.translation() / source.getResolution();
    samples_per_axis_ = std::max(1, static_cast<int>(std::ceil(scale_ - 1e-9)));
    half_extent_per_side_ = 0.5 * scale_ * rotation_.cwiseAbs().rowwise().sum();
  }

  State rootState() {
    State s(stack_);
    if (const auto* root = source_.getRoot()) s.add({root, OcTreeCube{}});
    return s;
  }

  State descend(const State& parent, unsigned, const OcTreeCube& cube) {
    if (cube.depth > kSampledDepth) return parent.view();
    State s(stack_);
    const Box box = boxInSource(cube);
    for (size_t i = 0; i < parent.size(); i++) {
      // A copy, because an addition can move the stack.
      // NOLINTNEXTLINE(performance-unnecessary-copy-initialization)
      const Piece piece = parent[i];
      addPieces(piece, box, cube.side() * scale_, s);
    }
    return s;
  }

  OcTreeFill visit(const OcTreeCube& cube, const State& s) {
    if (s.size() == 0) return OcTreeFill::unknown();
    if (cube.depth > kSampledDepth)
      return cube.depth < OcTreeCube::kMaxDepth ? OcTreeFill::split() : sample(cube, s);
    if (isUniform(s) && isCovered(boxInSource(cube), s))
      return OcTreeFill::leaf(s[0].node->getLogOdds());
    return OcTreeFill::split();
  }

 private:
  /** Depth of the cubes of 4 x 4 x 4 voxels whose pieces all their voxels use. A selection of
   * pieces for each smaller cube costs more than a search in all pieces of this cube. */
  static constexpr unsigned kSampledDepth = OcTreeCube::kMaxDepth - 2;

  Eigen::Vector3d toSource(const Eigen::Vector3d& p_new_grid) const {
    const Eigen::Vector3d p = (p_new_grid.array() - kGridOrigin).matrix() * scale_;
    return ((rotation_ * p + translation_).array() + kGridOrigin).matrix();
  }

  static Eigen::Vector3d centreOf(const OcTreeCube& c) {
    return Eigen::Vector3d(c.key[0], c.key[1], c.key[2]).array() + 0.5 * c.side();
  }

  Box boxInSource(const OcTreeCube& cube) const {
    const Eigen::Vector3d centre = toSource(centreOf(cube));
    const Eigen::Vector3d half = half_extent_per_side_ * cube.side();
    return {centre - half, centre + half};
  }

  /** Adds the parts of \a piece in \a box to \a s: leaves, or nodes no larger than \a side. */
  void addPieces(const Piece& piece, const Box& box, double side, State& s) const {
    if (box.volumeIn(piece.cube) <= 0) return;
    if (piece.cube.side() <= side || !source_.nodeHasChildren(piece.node)) {
      s.add(piece);
      return;
    }
    for (unsigned i = 0; i < 8; i++)
      if (source_.nodeChildExists(piece.node, i))
        addPieces({source_.getNodeChild(piece.node, i), piece.cube.child(i)}, box, side, s);
  }

  /** True if all pieces are leaves with the same value. */
  bool isUniform(const State& s) const {
    for (size_t i = 0; i < s.size(); i++)
      if (source_.nodeHasChildren(s[i].node) || s[i].node->getLogOdds() != s[0].node->getLogOdds())
        return false;
    return true;
  }

  /** True if the box has no unknown space: the pieces fill it. Pieces do not overlap. */
  static bool isCovered(const Box& box, const State& s) {
    double covered = 0;
    for (size_t i = 0; i < s.size(); i++) covered += box.volumeIn(s[i].cube);
    return covered >= (box.high - box.low).prod() * (1 - 1e-9);
  }

  OcTreeFill sample(const OcTreeCube& voxel, const State& s) {
    float highest = -std::numeric_limits<float>::infinity();
    const int n = samples_per_axis_;
    for (int z = 0; z < n; z++)
      for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++) {
          const Eigen::Vector3d offset = (Eigen::Vector3d(x, y, z).array() + 0.5) / n;
          const Eigen::Vector3d p =
              toSource(Eigen::Vector3d(voxel.key[0], voxel.key[1], voxel.key[2]) + offset);
          if (const auto* leaf = findLeaf(p, s)) highest = std::max(highest, leaf->getLogOdds());
        }
    return std::isinf(highest) ? OcTreeFill::unknown() : OcTreeFill::leaf(highest);
  }

  /** Returns the leaf at a point of the source grid, or null. */
  const OcTreeNode* findLeaf(const Eigen::Vector3d& p, const State& pieces) const {
    if (p.minCoeff() < 0 || p.maxCoeff() >= kGridSide) return nullptr;
    const uint32_t key[3] = {static_cast<uint32_t>(p.x()), static_cast<uint32_t>(p.y()),
                             static_cast<uint32_t>(p.z())};
    for (size_t j = 0; j < pieces.size(); j++) {
      const Piece& piece = pieces[j];
      bool inside = true;
      for (unsigned axis = 0; axis < 3; axis++)
        inside = inside && key[axis] >= piece.cube.key[axis] &&
                 key[axis] - piece.cube.key[axis] < piece.cube.side();
      if (!inside) continue;
      const OcTreeNode* node = piece.node;
      for (unsigned bit = OcTreeCube::kMaxDepth - piece.cube.depth;
           source_.nodeHasChildren(node);) {
        bit--;
        const unsigned i =
            ((key[0] >> bit) & 1U) | ((key[1] >> bit) & 1U) << 1U | ((key[2] >> bit) & 1U) << 2U;
        if (!source_.nodeChildExists(node, i)) return nullptr;
        node = source_.getNodeChild(node, i);
      }
      return node;
    }
    return nullptr;
  }

  const OcTree& source_;
  std::vector<Piece> stack_;
  double scale_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;
  int samples_per_axis_;
  Eigen::Vector3d half_extent_per_side_;
};

/** True if a voxel of \a map within half a voxel diagonal of a point is occupied. */
inline bool hasObstacleNear(const OcTree& map, const OcTreeKey& home, const Eigen::Vector3d& p) {
  const double reach2 = 0.75 * map.getResolution() * map.getResolution();
  const auto isObstacle = [&](const OcTreeKey& key) {
    const Eigen::Vector3d c(map.keyToCoord(key[0]), map.keyToCoord(key[1]), map.keyToCoord(key[2]));
    if ((c - p).squaredNorm() > reach2) return false;
    const auto* node = map.search(key);
    return node && map.isNodeOccupied(node);
  };
  if (isObstacle(home)) return true;  // usually
  for (int dz = -1; dz <= 1; dz++)
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++)
        if (isObstacle(OcTreeKey(static_cast<octomap::key_type>(home[0] + dx),
                                 static_cast<octomap::key_type>(home[1] + dy),
                                 static_cast<octomap::key_type>(home[2] + dz))))
          return true;
  return false;
}

/** Calls f(centre) for the voxels on the faces of a cube. Inner voxels are surrounded by occupied
 * voxels. Cubes wider than kWideLeaf are skipped: they cannot fall between the new centres. */
template <class F>
void forEachFaceVoxel(const OcTree& map, const OcTreeCube& cube, F&& f) {
  constexpr int kWideLeaf = 64;
  if (cube.side() > kWideLeaf) return;
  const int side = static_cast<int>(cube.side());
  const auto coord = [&](unsigned axis, int i) {
    return map.keyToCoord(static_cast<octomap::key_type>(cube.key[axis] + i));
  };
  const auto is_face = [side](int i) { return i == 0 || i == side - 1; };
  for (int z = 0; z < side; z++)
    for (int y = 0; y < side; y++)
      for (int x = 0; x < side; x++)
        if (is_face(x) || is_face(y) || is_face(z))
          f(Eigen::Vector3d(coord(0, x), coord(1, y), coord(2, z)));
}

inline void addOccupiedLeaves(const OcTree& map, const Piece& piece, std::vector<Piece>& leaves) {
  if (!map.nodeHasChildren(piece.node)) {
    if (map.isNodeOccupied(piece.node)) leaves.push_back(piece);
    return;
  }
  for (unsigned i = 0; i < 8; i++)
    if (map.nodeChildExists(piece.node, i))
      addOccupiedLeaves(map, {map.getNodeChild(piece.node, i), piece.cube.child(i)}, leaves);
}

/** Adds lost obstacles to \a grown. An occupied source voxel is lost if no voxel of \a grown within
 * half a voxel diagonal is occupied. The voxel of \a grown at its centre then gets its value. */
inline void keepThin(const OcTree& source, const Eigen::Isometry3d& T, OcTree& grown) {
  // A source voxel more than sqrt(3) times as wide as the new voxels always contains a new centre.
  if (source.getResolution() > std::sqrt(3.0) * grown.getResolution()) return;
  std::vector<Piece> leaves;
  if (source.getRoot()) addOccupiedLeaves(source, {source.getRoot(), OcTreeCube{}}, leaves);
  struct Lost {
    OcTreeKey key;
    float log_odds;
  };
  std::vector<Lost> lost;
  for (const Piece& leaf : leaves)
    forEachFaceVoxel(source, leaf.cube, [&](const Eigen::Vector3d& centre) {
      const Eigen::Vector3d p = T * centre;
      const OcTreeKey home = grown.coordToKey(p.x(), p.y(), p.z());
      if (!hasObstacleNear(grown, home, p)) lost.push_back({home, leaf.node->getLogOdds()});
    });
  // setNodeValue() clamps: without thresholds the values stay unchanged.
  const auto model = OcTreeAccess::sensorModel(grown);
  auto unclamped = model;
  unclamped.clamp_min = -std::numeric_limits<float>::max();
  unclamped.clamp_max = std::numeric_limits<float>::max();
  OcTreeAccess::setSensorModel(grown, unclamped);
  for (const Lost& l : lost) {
    const auto* node = grown.search(l.key);
    if (!node || node->getLogOdds() < l.log_odds) grown.setNodeValue(l.key, l.log_odds);
  }
  OcTreeAccess::setSensorModel(grown, model);
}

/** Returns what transformOcTree() must return. */
inline std::unique_ptr<OcTree> transformed(const OcTree& source, const Eigen::Isometry3d& T_dst_src,
                                           double resolution) {
  ResamplingVisitor visitor(source, T_dst_src.inverse(), resolution);
  auto result = built(resolution, OcTreeAccess::sensorModel(source), visitor.rootState(), visitor);
  keepThin(source, T_dst_src, *result);
  return result;
}

}  // namespace map_tests::reference
