// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Resamples an octree on another grid. */
#include "fusion_octree/resampling.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "fusion_octree/build.h"
#include "fusion_octree/walk.h"

namespace mrpt::fusion {
namespace {

using octomap::OcTree;
using octomap::OcTreeKey;
using octomap::OcTreeNode;

/** Side of the key space, and key of the frame's origin, voxels. */
constexpr double kGridSide = 65536.0;
constexpr double kGridOrigin = 32768.0;

/** Bounds the work of all copies of itself together. Whether they throw does not depend on the
 * number of threads. */
class WorkBudget {
 public:
  explicit WorkBudget(uint64_t most)
      : most_(most), left_(std::make_shared<std::atomic<int64_t>>(static_cast<int64_t>(most))) {}

  /** \exception std::length_error If all copies together have taken more than the budget. */
  void take(uint64_t work) {
    constexpr uint64_t kPiece = 4096;  // so that threads do not wait for each other
    taken_ += work;
    if (taken_ < kPiece) return;
    if (left_->fetch_sub(static_cast<int64_t>(taken_)) < static_cast<int64_t>(taken_))
      throw std::length_error(
          "the map has few nodes and large cubes: to turn or refine them takes more than " +
          std::to_string(most_) + " voxels");
    taken_ = 0;
  }

 private:
  uint64_t most_;  // work of all copies
  std::shared_ptr<std::atomic<int64_t>> left_;
  uint64_t taken_ = 0;  // work of this copy since it was last counted
};

/** Returns the largest work for an octree, in voxels that are looked up. A tiny file can hold a
 * leaf with billions of voxels on its faces. The nodes of a map that was seen by a sensor need a
 * fraction of this work. */
uint64_t mostWorkFor(const OcTree& source, double resolution) {
  constexpr uint64_t kLeast = uint64_t{1} << 25U;  // 1 s, 250 MB
  // A node of the source meets few blocks of 4 x 4 x 4 new voxels, and more of them if the new
  // voxels are finer.
  constexpr double kPerBlock = 128, kFinest = 8;
  const double finer = std::clamp(source.getResolution() / resolution, 0.0, kFinest);
  const double per_node = kPerBlock * std::pow(1 + finer / 4, 3);
  return kLeast + static_cast<uint64_t>(per_node * static_cast<double>(source.size()));
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

  ResamplingVisitor(const OcTree& source, const Eigen::Isometry3d& T_src_dst, double resolution,
                    const WorkBudget& budget)
      : source_(source), budget_(budget) {
    // From voxel units of the new grid to voxel units of the source grid.
    scale_ = resolution / source.getResolution();
    rotation_ = T_src_dst.linear();
    translation_ = T_src_dst.translation() / source.getResolution();
    samples_per_axis_ = std::max(1, static_cast<int>(std::ceil(scale_ - 1e-9)));
    work_per_voxel_ = 1 + static_cast<uint64_t>(std::pow(samples_per_axis_, 3) / kSamplesPerWork);
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
  /** Number of samples that take as long as to make a voxel. */
  static constexpr double kSamplesPerWork = 16;

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
    budget_.take(work_per_voxel_);
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
  WorkBudget budget_;
  uint64_t work_per_voxel_;
  std::vector<Piece> stack_;
  double scale_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;
  int samples_per_axis_;
  Eigen::Vector3d half_extent_per_side_;
};

/** Throws if the known space of \a source does not fit the new grid. */
void checkFits(const OcTree& source, const Eigen::Isometry3d& T, double resolution) {
  if (!source.getRoot()) return;
  const Eigen::AlignedBox3d known = knownSpace(source);
  const Eigen::Vector3d centre = T * known.center();
  const Eigen::Vector3d half = T.linear().cwiseAbs() * (0.5 * known.sizes());
  if ((centre.cwiseAbs() + half).maxCoeff() > (kGridOrigin + 1e-6) * resolution)
    throw std::out_of_range("the transformed map does not fit an octree of this resolution");
}

/** True if a voxel of \a map within half a voxel diagonal of a point is occupied. */
bool hasObstacleNear(const OcTree& map, const OcTreeKey& home, const Eigen::Vector3d& p) {
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

void addOccupiedLeaves(const OcTree& map, const Piece& piece, std::vector<Piece>& leaves) {
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
void keepThinObstacles(const OcTree& source, const Eigen::Isometry3d& T, const WorkBudget& budget,
                       OcTree& grown) {
  // A source voxel more than sqrt(3) times as wide as the new voxels always contains a new centre.
  if (source.getResolution() > std::sqrt(3.0) * grown.getResolution()) return;
  std::vector<Piece> leaves;
  if (source.getRoot()) addOccupiedLeaves(source, {source.getRoot(), OcTreeCube{}}, leaves);
  struct Lost {
    OcTreeKey key;
    float log_odds;
  };
  // Lost voxels are added after the search, so that the result does not depend on their order.
  constexpr size_t kGrain = 1024;
  std::vector<std::vector<Lost>> lost((leaves.size() + kGrain - 1) / kGrain);
  tbb::parallel_for(size_t{0}, lost.size(), [&](size_t g) {
    WorkBudget own = budget;
    for (size_t i = g * kGrain; i < std::min((g + 1) * kGrain, leaves.size()); i++)
      forEachFaceVoxel(source, leaves[i].cube, [&](const Eigen::Vector3d& centre) {
        own.take(1);
        const Eigen::Vector3d p = T * centre;
        const OcTreeKey home = grown.coordToKey(p.x(), p.y(), p.z());
        if (!hasObstacleNear(grown, home, p))
          lost[g].push_back({home, leaves[i].node->getLogOdds()});
      });
  });
  // setNodeValue() clamps: without thresholds the values stay unchanged.
  const auto model = OcTreeAccess::sensorModel(grown);
  auto unclamped = model;
  unclamped.clamp_min = -std::numeric_limits<float>::max();
  unclamped.clamp_max = std::numeric_limits<float>::max();
  OcTreeAccess::setSensorModel(grown, unclamped);
  for (const auto& some : lost)
    for (const Lost& l : some) {
      const auto* node = grown.search(l.key);
      if (!node || node->getLogOdds() < l.log_odds) grown.setNodeValue(l.key, l.log_odds);
    }
  OcTreeAccess::setSensorModel(grown, model);
}

}  // namespace

std::unique_ptr<OcTree> transformOcTree(const OcTree& source, const Eigen::Isometry3d& T_dst_src,
                                        double resolution) {
  if (!T_dst_src.matrix().allFinite())
    throw std::invalid_argument("transformOcTree: the transform is not finite");
  if (!(resolution > 0) || !std::isfinite(resolution))
    throw std::invalid_argument("transformOcTree: the resolution must be a positive length");
  constexpr double kMostCoarser = 64;  // the number of samples of a voxel grows with its cube
  if (resolution > kMostCoarser * source.getResolution())
    throw std::invalid_argument("transformOcTree: the new voxels are more than 64 times as wide");
  checkFits(source, T_dst_src, resolution);

  auto result = std::make_unique<OcTree>(resolution);
  OcTreeAccess::setSensorModel(*result, OcTreeAccess::sensorModel(source));
  const WorkBudget budget(mostWorkFor(source, resolution));
  buildOcTreeInParallel(*result,
                        ResamplingVisitor(source, T_dst_src.inverse(), resolution, budget));
  keepThinObstacles(source, T_dst_src, budget, *result);
  return result;
}

}  // namespace mrpt::fusion
