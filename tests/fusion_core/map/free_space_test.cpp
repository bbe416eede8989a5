// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/map/free_space.h"

#include <gtest/gtest.h>
#include <mrpt/fusion/voxels.h>

#include <algorithm>
#include <vector>

#include "fusion_core/map/map_voxels.h"
#include "fusion_octree/build.h"
#include "fusion_octree/walk.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::free_space_test {
namespace {

using mrpt::fusion::OcTreeCube;

constexpr int kSide = RandomVisitor::kSide;
constexpr octomap::key_type kLow = RandomVisitor::kLow;

FreeSpace freeSpaceOf(const octomap::OcTree& map) {
  FreeSpace free;
  extractOccupiedVoxels(map, free);
  return free;
}

bool isFreeIn(const octomap::OcTree& map, const octomap::OcTreeKey& key) {
  const octomap::OcTreeNode* node = map.search(key);
  return node && !map.isNodeOccupied(node);
}

TEST(FreeSpace, IsWhatTheTreeSays) {
  const auto tree = randomTree();
  const octomap::OcTree& map = *tree;
  std::array<size_t, OcTreeCube::kMaxDepth + 1> leaves{};
  mrpt::fusion::forEachLeaf(map, [&](const OcTreeCube& leaf, const auto& node) {
    if (!map.isNodeOccupied(node)) leaves[leaf.depth]++;
  });
  for (unsigned depth = 10; depth <= 16; depth++) ASSERT_GT(leaves[depth], 0) << depth;

  const FreeSpace free = freeSpaceOf(map);
  constexpr int kBeyond = 5;
  for (int x = kLow - kBeyond; x < kLow + kSide + kBeyond; x++)
    for (int y = kLow - kBeyond; y < kLow + kSide + kBeyond; y++)
      for (int z = kLow - kBeyond; z < kLow + kSide + kBeyond; z++) {
        const octomap::OcTreeKey key(static_cast<octomap::key_type>(x),
                                     static_cast<octomap::key_type>(y),
                                     static_cast<octomap::key_type>(z));
        ASSERT_EQ(free.has(key), isFreeIn(map, key)) << x << " " << y << " " << z;
      }
}

TEST(FreeSpace, CubesHoldAllThatIsFreeAndNoneHoldsNothing) {
  const auto tree = randomTree();
  const octomap::OcTree& map = *tree;
  const FreeSpace free = freeSpaceOf(map);
  for (const unsigned height : {0U, 1U, 2U, 5U}) {
    const int side = 1 << std::min(height, 2U), cells = kSide / side;
    const auto indexOf = [&](int x, int y, int z) {
      return static_cast<size_t>((z * cells + y) * cells + x);
    };
    std::vector<bool> expected(indexOf(0, 0, cells)), found(expected.size());
    for (int x = 0; x < kSide; x++)
      for (int y = 0; y < kSide; y++)
        for (int z = 0; z < kSide; z++)
          if (free.has({static_cast<octomap::key_type>(kLow + x),
                        static_cast<octomap::key_type>(kLow + y),
                        static_cast<octomap::key_type>(kLow + z)}))
            expected[indexOf(x / side, y / side, z / side)] = true;
    free.forEachCube(height, [&](const OcTreeCube& cube) {
      ASSERT_GE(static_cast<int>(cube.side()), side);
      const int n = static_cast<int>(cube.side()) / side;
      const int x = (cube.key[0] - kLow) / side, y = (cube.key[1] - kLow) / side,
                z = (cube.key[2] - kLow) / side;
      for (int i = 0; i < n * n * n; i++)
        found.at(indexOf(x + i % n, y + i / n % n, z + i / n / n)) = true;
    });
    EXPECT_TRUE(found == expected) << height;
  }
}

TEST(FreeSpace, OneLeafStandsForTheWholeSpace) {
  octomap::OcTree map(0.1);
  mrpt::fusion::OcTreeAccess::createRoot(map)->setLogOdds(-2);
  const FreeSpace free = freeSpaceOf(map);
  for (const octomap::key_type k : {0, 1, 32767, 32768, 65535}) EXPECT_TRUE(free.has({k, 7, k}));
  std::vector<unsigned> depths;
  free.forEachCube(0, [&](const OcTreeCube& cube) { depths.push_back(cube.depth); });
  EXPECT_EQ(depths, std::vector<unsigned>{0});
}

TEST(FreeSpace, NothingIsFreeInAnEmptyMap) {
  EXPECT_FALSE(FreeSpace().has({32768, 32768, 32768}));
  EXPECT_FALSE(freeSpaceOf(octomap::OcTree(0.1)).has({0, 0, 0}));
  FreeSpace().forEachCube(2, [](const OcTreeCube&) { ADD_FAILURE(); });
}

TEST(FreeSpace, OccupiedVoxelsAreTheSameWithoutIt) {
  const auto map = MapWriter(0.2)
                       .box({-9, 3, 0}, {14, 9, 6}, kFree)
                       .box({-9, 3, 0}, {14, 9, 0}, kOccupied)
                       .pruned();
  FreeSpace free;
  const OccupiedVoxels with = extractOccupiedVoxels(*map, free),
                       without = extractOccupiedVoxels(*map);
  EXPECT_EQ(with.key, without.key);
  EXPECT_EQ(with.centre, without.centre);
  EXPECT_EQ(with.probability, without.probability);
  EXPECT_THROW(extractOccupiedVoxels(*map, free, with.size() - 1), std::length_error);
}

}  // namespace
}  // namespace mrpt::fusion::test::free_space_test
