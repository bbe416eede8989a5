// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Finds obstacles that resampling lost, and adds them. */
#include "fusion_octree/thin_obstacles.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "fusion_base/bits.h"
#include "fusion_base/parallel.h"
#include "fusion_octree/occupied_cubes.h"

namespace mrpt::fusion {
namespace {

using octomap::OcTree;
using octomap::OcTreeKey;

/** True if a voxel of the new grid within half a voxel diagonal of a point is occupied.
 * \param[in] grid An octree on the new grid.
 * \param[in,out] occupied The occupied voxels.
 * \param[in] home The voxel that contains the point.
 * \param[in] p The point, m. */
bool hasObstacleNear(const OcTree& grid, OccupiedCubes::Lookup& occupied, const OcTreeKey& home,
                     const Eigen::Vector3d& p) {
  const double reach2 = 0.75 * grid.getResolution() * grid.getResolution();
  const auto isObstacle = [&](const OcTreeKey& key) {
    const Eigen::Vector3d c(grid.keyToCoord(key[0]), grid.keyToCoord(key[1]),
                            grid.keyToCoord(key[2]));
    return !((c - p).squaredNorm() > reach2) && occupied.contains(key);
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

/** Returns the key of the voxel at a point: OctoMap's coordToKey(), without a call of floor().
 * \param[in] p The point, m; inside the grid.
 * \param[in] voxels_per_metre 1 / the voxel size. */
OcTreeKey keyOf(const Eigen::Vector3d& p, double voxels_per_metre) {
  constexpr int kOrigin = 1 << (OcTreeCube::kMaxDepth - 1);
  OcTreeKey key;
  for (unsigned axis = 0; axis < 3; axis++) {
    const double scaled = voxels_per_metre * p[axis];
    const int towards_zero = static_cast<int>(scaled);
    const int floor = towards_zero - static_cast<int>(scaled < towards_zero);
    key[axis] = static_cast<octomap::key_type>(floor + kOrigin);
  }
  return key;
}

/** A voxel of the new grid at a lost obstacle. */
struct LostVoxel {
  OcTreeKey key;
  float log_odds;
};

/** A leaf or a block of the source with occupied voxels. */
struct Piece {
  const BlockTree::Node* node;
  OcTreeCube cube;
  uint64_t occupied;  // voxels of a block, x fastest
};

/** Returns the leaves and blocks with occupied voxels. Leaves wider than 64 voxels are left out:
 * they cannot fall between the new centres. */
std::vector<Piece> occupiedPieces(const BlockTree& blocks, float threshold) {
  constexpr uint32_t kWideLeaf = 64;
  std::vector<Piece> pieces;
  blocks.forEachLeafOrBlock([&](const BlockTree::Node& node, const OcTreeCube& cube) {
    uint64_t occupied = 0;
    if (node.kind == BlockTree::Kind::Leaf)
      occupied = node.log_odds >= threshold && cube.side() <= kWideLeaf ? 1 : 0;
    else
      for (unsigned i = VoxelBlock::kVoxels; i-- > 0;)
        occupied = occupied << 1U | static_cast<unsigned>((*node.values)[i] >= threshold);
    if (occupied) pieces.push_back({&node, cube, occupied});
  });
  return pieces;
}

/** Calls `f(key, log_odds)` for the occupied voxels of a block, or for the voxels on the faces of a
 * leaf. Inner voxels of a leaf are surrounded by occupied voxels. */
template <class F>
void forEachOuterVoxel(const Piece& piece, F&& f) {
  if (piece.node->kind == BlockTree::Kind::Leaf) {
    forEachFaceVoxel(piece.cube, [&](const OcTreeKey& key) { f(key, piece.node->log_odds); });
    return;
  }
  const BlockTree::Values& values = *piece.node->values;
  for (uint64_t left = piece.occupied; left; left &= left - 1) {
    const auto i = static_cast<unsigned>(lowestBit(left));
    f(OcTreeKey(static_cast<octomap::key_type>(piece.cube.key[0] + (i & 3U)),
                static_cast<octomap::key_type>(piece.cube.key[1] + (i >> 2U & 3U)),
                static_cast<octomap::key_type>(piece.cube.key[2] + (i >> 4U))),
      values[i]);
  }
}

/** Returns the number of a voxel in the order of the octree. */
uint64_t orderOf(const OcTreeKey& key) {
  uint64_t order = 0;
  for (unsigned bit = 0; bit < OcTreeCube::kMaxDepth; bit++)
    for (unsigned axis = 0; axis < 3; axis++)
      order |= static_cast<uint64_t>(key[axis] >> bit & 1U) << (3 * bit + axis);
  return order;
}

/** Adds lost voxels to a map. */
class Addition {
 public:
  /** \param[in] lost The lost voxels. Of several values of a voxel, the highest counts. */
  explicit Addition(const std::vector<LostVoxel>& lost) {
    for (const LostVoxel& l : lost) lost_.push_back({orderOf(l.key), l});
    std::stable_sort(lost_.begin(), lost_.end(),
                     [](const Lost& a, const Lost& b) { return a.order < b.order; });
  }

  void addTo(CubeList& cubes) {
    next_ = lost_.cbegin();
    for (const ListedCube& c : cubes.cubes()) {
      const uint64_t begin = orderOf(c.cube.key);
      const uint64_t end = begin + (uint64_t{1} << (3 * (OcTreeCube::kMaxDepth - c.cube.depth)));
      while (next_ != lost_.cend() && next_->order < begin) addUnknownBlock();
      if (next_ == lost_.cend() || next_->order >= end)
        out_.addCube(c);
      else if (c.block)
        addBlock(c.cube, *c.block);
      else
        addLeaf(c.cube, c.log_odds);
    }
    while (next_ != lost_.cend()) addUnknownBlock();
    out_.keepBlocksOf(std::move(cubes));
    cubes = std::move(out_);
  }

 private:
  struct Lost {
    uint64_t order;
    LostVoxel voxel;
  };

  static OcTreeCube blockAt(const OcTreeKey& key) {
    OcTreeCube cube{key, VoxelBlock::kDepth};
    for (unsigned axis = 0; axis < 3; axis++)
      cube.key[axis] = static_cast<octomap::key_type>(key[axis] & ~3U);
    return cube;
  }
  void addUnknownBlock() { addBlock(blockAt(next_->voxel.key), VoxelBlock()); }
  /** Adds a block with all lost voxels in it. */
  void addBlock(const OcTreeCube& cube, VoxelBlock block) {
    for (; next_ != lost_.cend() && cube.contains({next_->voxel.key, OcTreeCube::kMaxDepth});
         ++next_) {
      const unsigned i = VoxelBlock::indexOf(next_->voxel.key);
      if (!block.isKnown(i) || block.value[i] < next_->voxel.log_odds)
        block.set(i, next_->voxel.log_odds);
    }
    out_.addBlock(cube, block);
  }
  /** Adds a leaf that contains lost voxels. */
  void addLeaf(const OcTreeCube& cube, float log_odds) {
    if (next_ == lost_.cend() || !cube.contains({next_->voxel.key, OcTreeCube::kMaxDepth}))
      return out_.addLeaf(cube, log_odds);
    if (cube.depth == VoxelBlock::kDepth) {
      VoxelBlock block;
      block.fill(log_odds);
      return addBlock(cube, block);
    }
    for (unsigned i = 0; i < 8; i++) addLeaf(cube.child(i), log_odds);
  }

  std::vector<Lost> lost_;
  std::vector<Lost>::const_iterator next_;
  CubeList out_;
};

}  // namespace

void keepThinObstacles(const OcTree& source, const BlockTree& blocks, const Eigen::Isometry3d& T,
                       double resolution, const WorkBudget& budget, CubeList& cubes) {
  // A source voxel more than sqrt(3) times as wide as the new voxels always contains a new centre.
  if (source.getResolution() > std::sqrt(3.0) * resolution) return;
  const OcTree grid(resolution);
  const float threshold = source.getOccupancyThresLog();
  const OccupiedCubes occupied(cubes, threshold);
  const std::vector<Piece> pieces = occupiedPieces(blocks, threshold);
  // Lost voxels are added after the search, so that the result does not depend on their order.
  constexpr size_t kPiecesPerTask = 256;
  std::vector<std::vector<LostVoxel>> lost((pieces.size() + kPiecesPerTask - 1) / kPiecesPerTask);
  forEachIndex(lost.size(), 1, [&](size_t g) {
    WorkBudget own = budget;
    OccupiedCubes::Lookup lookup(occupied);
    for (size_t i = g * kPiecesPerTask; i < std::min((g + 1) * kPiecesPerTask, pieces.size()); i++)
      forEachOuterVoxel(pieces[i], [&](const OcTreeKey& key, float log_odds) {
        own.take(1);
        const Eigen::Vector3d p =
            T * Eigen::Vector3d(source.keyToCoord(key[0]), source.keyToCoord(key[1]),
                                source.keyToCoord(key[2]));
        const OcTreeKey home = keyOf(p, 1 / resolution);
        if (!hasObstacleNear(grid, lookup, home, p)) lost[g].push_back({home, log_odds});
      });
  });
  std::vector<LostVoxel> all;
  for (const auto& some : lost) all.insert(all.end(), some.begin(), some.end());
  if (!all.empty()) Addition(all).addTo(cubes);
}

}  // namespace mrpt::fusion
