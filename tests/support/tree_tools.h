// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "fusion_octree/build.h"
#include "fusion_octree/files.h"
#include "support/file_tools.h"
#include "support/sanitizers.h"

/** \file
 * What several test files need: octrees of every shape, and ways to look at them that do not go
 * through the code under test.
 */

namespace map_tests {

inline uint32_t bitsOf(float v) {
  uint32_t bits;
  std::memcpy(&bits, &v, sizeof(bits));
  return bits;
}

// ---------------------------------------------------------------- inspection of octrees

/** Place and value of a node of an octree, bit for bit. */
struct NodeRecord {
  std::array<unsigned, 3> key;
  unsigned depth;
  bool leaf;
  uint32_t bits;

  bool operator==(const NodeRecord& o) const {
    return key == o.key && depth == o.depth && leaf == o.leaf && bits == o.bits;
  }
};

inline std::ostream& operator<<(std::ostream& o, const NodeRecord& n) {
  float log_odds;
  std::memcpy(&log_odds, &n.bits, sizeof(log_odds));
  return o << (n.leaf ? "leaf" : "node") << " at " << n.key[0] << "," << n.key[1] << "," << n.key[2]
           << " depth " << n.depth << " log-odds " << log_odds;
}

/** Returns all nodes in pre-order, including inner nodes. Two octrees are equal if and only if
 * their nodes are equal. */
inline std::vector<NodeRecord> nodesOf(const octomap::OcTree& tree) {
  std::vector<NodeRecord> nodes;
  for (auto it = tree.begin_tree(); it != tree.end_tree(); ++it) {
    const auto k = it.getKey();
    nodes.push_back({{k[0], k[1], k[2]}, it.getDepth(), it.isLeaf(), bitsOf(it->getLogOdds())});
  }
  return nodes;
}

inline std::vector<NodeRecord> leavesOf(const octomap::OcTree& tree) {
  auto nodes = nodesOf(tree);
  nodes.erase(std::remove_if(nodes.begin(), nodes.end(), [](const auto& n) { return !n.leaf; }),
              nodes.end());
  return nodes;
}

/** Compares nodes. The message names the first node that differs. */
inline testing::AssertionResult sameNodes(const std::vector<NodeRecord>& a,
                                          const std::vector<NodeRecord>& b) {
  for (size_t i = 0; i < std::min(a.size(), b.size()); i++)
    if (!(a[i] == b[i]))
      return testing::AssertionFailure() << "node " << i << ": " << a[i] << " versus " << b[i];
  if (a.size() != b.size())
    return testing::AssertionFailure() << a.size() << " versus " << b.size() << " nodes";
  return testing::AssertionSuccess();
}

inline testing::AssertionResult sameTree(const octomap::OcTree& a, const octomap::OcTree& b) {
  if (a.getResolution() != b.getResolution())
    return testing::AssertionFailure()
           << "resolution " << a.getResolution() << " versus " << b.getResolution();
  if (a.size() != b.size())
    return testing::AssertionFailure() << "size() " << a.size() << " versus " << b.size();
  return sameNodes(nodesOf(a), nodesOf(b));
}

inline std::array<uint32_t, 5> sensorModelBits(const octomap::OcTree& t) {
  return {bitsOf(t.getClampingThresMinLog()), bitsOf(t.getClampingThresMaxLog()),
          bitsOf(t.getProbHitLog()), bitsOf(t.getProbMissLog()), bitsOf(t.getOccupancyThresLog())};
}

/** Coordinates of a finest voxel on the grid. The lowest corner of (0,0,0) is at the origin. */
using VoxelIndex = std::array<int, 3>;
using VoxelMap = std::map<VoxelIndex, float>;

constexpr int kOriginKey = 32768;

/** Returns the log-odds of all finest voxels in an octree's leaves. */
inline VoxelMap voxelsOf(const octomap::OcTree& tree) {
  VoxelMap voxels;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it) {
    const auto low = it.getIndexKey();
    const int side = 1 << (tree.getTreeDepth() - it.getDepth());
    for (int x = 0; x < side; x++)
      for (int y = 0; y < side; y++)
        for (int z = 0; z < side; z++)
          voxels[{low[0] - kOriginKey + x, low[1] - kOriginKey + y, low[2] - kOriginKey + z}] =
              it->getLogOdds();
  }
  return voxels;
}

/** Compares two voxel maps. The message names the first voxel that differs. */
template <class Value>
testing::AssertionResult sameVoxels(const std::map<VoxelIndex, Value>& a,
                                    const std::map<VoxelIndex, Value>& b) {
  size_t differing = 0;
  std::ostringstream first;
  const auto differ = [&](const VoxelIndex& k, const auto* va, const auto* vb) {
    if (differing++) return;
    first << "voxel " << k[0] << "," << k[1] << "," << k[2] << ": ";
    va ? first << *va : first << "unknown";
    first << " versus ";
    vb ? first << *vb : first << "unknown";
  };
  const Value* const none = nullptr;
  for (const auto& [k, va] : a) {
    const auto it = b.find(k);
    if (it == b.end())
      differ(k, &va, none);
    else if (va != it->second)
      differ(k, &va, &it->second);
  }
  for (const auto& [k, vb] : b)
    if (!a.count(k)) differ(k, none, &vb);
  if (!differing) return testing::AssertionSuccess();
  return testing::AssertionFailure() << differing << " voxels differ of " << a.size() << " and "
                                     << b.size() << "; " << first.str();
}

// ---------------------------------------------------------------- construction of octrees

inline octomap::OcTreeKey keyOf(const VoxelIndex& v) {
  return {static_cast<octomap::key_type>(v[0] + kOriginKey),
          static_cast<octomap::key_type>(v[1] + kOriginKey),
          static_cast<octomap::key_type>(v[2] + kOriginKey)};
}

/** Adds a leaf at a depth, without clamping and pruning. OctoMap's setters clamp and prune. */
inline void putLeaf(octomap::OcTree& tree, const VoxelIndex& where, unsigned depth,
                    float log_odds) {
  const auto key = keyOf(where);
  auto* node = tree.getRoot() ? tree.getRoot() : mrpt::fusion::OcTreeAccess::createRoot(tree);
  for (unsigned d = 0; d < depth; d++) {
    const auto i = octomap::computeChildIdx(key, static_cast<int>(tree.getTreeDepth() - 1 - d));
    node =
        tree.nodeChildExists(node, i) ? tree.getNodeChild(node, i) : tree.createNodeChild(node, i);
  }
  node->setLogOdds(log_odds);
}

inline void putVoxel(octomap::OcTree& tree, const VoxelIndex& where, float log_odds) {
  putLeaf(tree, where, tree.getTreeDepth(), log_odds);
}

/** Sets inner nodes to the maximum of their children and prunes equal siblings, as in OctoMap. */
inline void finish(octomap::OcTree& tree) {
  tree.updateInnerOccupancy();
  tree.prune();
}

/** Returns an octree with difficult cases for file formats: equal siblings that are not pruned,
 * leaves at several depths, values beyond the clamping thresholds, the least and the greatest
 * float, negative zero, and inner nodes that do not hold the maximum of their children. */
inline std::unique_ptr<octomap::OcTree> awkwardTree(double resolution) {
  auto tree = std::make_unique<octomap::OcTree>(resolution);
  for (int i = 0; i < 8; i++) putVoxel(*tree, {i & 1, (i >> 1) & 1, i >> 2}, 0.85F);
  const float limits[] = {-0.0F,   0.0F,   std::numeric_limits<float>::denorm_min(),
                          -1e-30F, 1e-9F,  std::numeric_limits<float>::max(),
                          -1e30F,  123.4F, std::numeric_limits<float>::lowest()};
  int x = -40;
  for (const float v : limits) putVoxel(*tree, {x++, 7, -9}, v);
  putLeaf(*tree, {-16384, -16384, 0}, 3, -1.7F);
  putLeaf(*tree, {1024, 0, 0}, 9, 2.4F);
  std::mt19937 rng(7);
  std::uniform_real_distribution<float> value(-9, 9);
  std::uniform_int_distribution<int> place(-60, 60);
  for (int i = 0; i < 300; i++)
    putVoxel(*tree, {100 + place(rng), place(rng), place(rng)}, value(rng));
  tree->getRoot()->setLogOdds(0.123F);
  return tree;
}

/** Returns an octree with a few nodes, for tests that run once per byte. */
inline std::unique_ptr<octomap::OcTree> smallTree() {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  putVoxel(*tree, {0, 0, 0}, 1.5F);
  putVoxel(*tree, {-1, -1, -1}, -0.4F);
  putLeaf(*tree, {64, 0, 0}, 10, -2.0F);
  finish(*tree);
  return tree;
}

/** Returns a part of a building around the origin: walls 1 voxel thick, pruned blocks, single
 * voxels, free space in leaves of several sizes, and unknown space between them. */
inline std::unique_ptr<octomap::OcTree> sceneTree(double resolution, unsigned seed) {
  auto tree = std::make_unique<octomap::OcTree>(resolution);
  std::mt19937 rng(seed);
  std::uniform_int_distribution<int> place(-20, 19);
  const auto value = [&](float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(rng);
  };
  for (int x = -18; x < 14; x++)
    for (int y = -16; y < 16; y++)
      for (int z = -8; z < 8; z++) putVoxel(*tree, {x, y, z}, -1.25F);  // pruned to large leaves
  for (int i = 0; i < 300; i++)
    putVoxel(*tree, {place(rng), place(rng), place(rng)}, value(-2, -0.1F));
  for (int y = -16; y < 10; y++)
    for (int z = -10; z < 8; z++) putVoxel(*tree, {-18, y, z}, value(0.1F, 3.5F));
  for (int x = -18; x < 5; x++)
    for (int z = -10; z < 8; z++) putVoxel(*tree, {x, -16, z}, 2.5F);
  for (const VoxelIndex& corner : {VoxelIndex{20, 4, -4}, VoxelIndex{4, 20, 8}})
    for (int i = 0; i < 64; i++)
      putVoxel(*tree, {corner[0] + (i & 3), corner[1] + ((i >> 2) & 3), corner[2] + (i >> 4)},
               3.5F);
  for (int i = 0; i < 8; i++)
    putVoxel(*tree, {-24 + (i & 1), 22 + ((i >> 1) & 1), 10 + (i >> 2)}, 1.75F);
  for (int i = 0; i < 80; i++)
    putVoxel(*tree, {place(rng), place(rng), place(rng)}, value(0.1F, 3.5F));
  finish(*tree);
  return tree;
}

// ---------------------------------------------------------------- memory

/** Limits the memory of the process while the object exists. Larger allocations throw
 * std::bad_alloc. */
class MemoryLimit {
 public:
  explicit MemoryLimit(size_t megabytes) {
    ::getrlimit(RLIMIT_AS, &old_);
    if (kHasSanitizer) return;
    size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    rlimit limit = old_;
    limit.rlim_cur = pages * static_cast<size_t>(::sysconf(_SC_PAGESIZE)) + (megabytes << 20);
    ::setrlimit(RLIMIT_AS, &limit);
  }
  ~MemoryLimit() { ::setrlimit(RLIMIT_AS, &old_); }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit old_{};
};

}  // namespace map_tests
