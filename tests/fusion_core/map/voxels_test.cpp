// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/fusion/voxels.h>

#include <cmath>
#include <map>
#include <stdexcept>

#include "fusion_core/map/free_space.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_octree/build.h"
#include "fusion_octree/walk.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::voxels_test {
namespace {

using Key = std::array<uint16_t, 3>;

/** Probability by key: what a set of voxels is, whatever its order. */
std::map<Key, float> byKey(const OccupiedVoxels& v) {
  std::map<Key, float> m;
  for (size_t i = 0; i < v.size(); i++)
    m[{v.key[i][0], v.key[i][1], v.key[i][2]}] = v.probability[i];
  return m;
}

TEST(ExtractOccupiedVoxels, GivesCentreKeyAndProbabilityOfEach) {
  const auto map = MapWriter(0.2)
                       .voxel({0, 0, 0}, 1.0F)
                       .voxel({-3, 7, 2}, kOccupied)
                       .voxel({5, 5, 5}, kFree)
                       .unpruned();
  const OccupiedVoxels v = extractOccupiedVoxels(*map);
  ASSERT_EQ(v.size(), 2);
  EXPECT_DOUBLE_EQ(v.resolution, 0.2);
  const size_t first = v.key[0] == keyOf({0, 0, 0}) ? 0 : 1;
  EXPECT_EQ(v.key[first], keyOf({0, 0, 0}));
  EXPECT_EQ(v.key[1 - first], keyOf({-3, 7, 2}));
  EXPECT_TRUE(v.centre[first].isApprox(Eigen::Vector3f(0.1F, 0.1F, 0.1F)));
  EXPECT_TRUE(v.centre[1 - first].isApprox(Eigen::Vector3f(-0.5F, 1.5F, 0.5F)));
  EXPECT_NEAR(v.probability[first], 1 / (1 + std::exp(-1.0)), 1e-6);
  EXPECT_NEAR(v.probability[1 - first], 1 / (1 + std::exp(-3.5)), 1e-6);
}

TEST(ExtractOccupiedVoxels, ExpandsPrunedLeaves) {
  // 16^3 voxels, aligned: one leaf at depth 12; and a slab that prunes in part.
  MapWriter writer;
  writer.box({16, -16, 0}, {31, -1, 15}, kOccupied).box({40, 0, 0}, {47, 6, 2}, 0.8F);
  const auto pruned = writer.pruned();
  octomap::OcTree expanded(*pruned);
  expanded.expand();
  ASSERT_LT(pruned->getNumLeafNodes(), 100);
  ASSERT_EQ(expanded.getNumLeafNodes(), 16 * 16 * 16 + 8 * 7 * 3);

  const OccupiedVoxels v = extractOccupiedVoxels(*pruned);
  EXPECT_EQ(v.size(), expanded.getNumLeafNodes());
  EXPECT_EQ(byKey(v), byKey(extractOccupiedVoxels(expanded)));
  for (size_t i = 0; i < v.size(); i++) {
    const octomap::point3d centre = pruned->keyToCoord(v.key[i]);
    ASSERT_EQ(v.centre[i], Eigen::Vector3f(centre.x(), centre.y(), centre.z()));
  }
}

TEST(ExtractOccupiedVoxels, GoesInTheOrderOfTheOctreesLeaves) {
  const auto tree = randomTree();
  OccupiedVoxels expected;
  mrpt::fusion::forEachLeaf(*tree, [&](const mrpt::fusion::OcTreeCube& cube, const auto& leaf) {
    if (!tree->isNodeOccupied(leaf)) return;
    mrpt::fusion::forEachVoxel(cube, [&](const octomap::OcTreeKey& key) {
      const octomap::point3d centre = tree->keyToCoord(key);
      expected.key.push_back(key);
      expected.centre.emplace_back(centre.x(), centre.y(), centre.z());
      expected.probability.push_back(static_cast<float>(leaf.getOccupancy()));
    });
  });
  ASSERT_GT(expected.size(), 1000);
  FreeSpace free;
  for (const OccupiedVoxels& v :
       {extractOccupiedVoxels(*tree), extractOccupiedVoxels(*tree, free)}) {
    EXPECT_EQ(v.key, expected.key);
    EXPECT_EQ(v.centre, expected.centre);
    EXPECT_EQ(v.probability, expected.probability);
  }
}

TEST(ExtractOccupiedVoxels, GoesByTheMapsOwnOccupancyThreshold) {
  auto map =
      MapWriter().voxel({0, 0, 0}, 0.0F).voxel({1, 0, 0}, 0.5F).voxel({2, 0, 0}, 2.F).unpruned();
  EXPECT_EQ(extractOccupiedVoxels(*map).size(), 3);  // 0.5 is the default: p = 0.5 is occupied
  map->setOccupancyThres(0.7);
  EXPECT_EQ(extractOccupiedVoxels(*map).size(), 1);
}

TEST(ExtractOccupiedVoxels, EmptyMapHasNone) {
  EXPECT_EQ(extractOccupiedVoxels(octomap::OcTree(0.1)).size(), 0);
}

TEST(ExtractOccupiedVoxels, RefusesMoreThanTheLimitAndTakesJustAsMany) {
  const auto map =
      MapWriter().box({0, 0, 0}, {7, 7, 7}, kOccupied).box({9, 0, 0}, {9, 0, 4}, 1.F).pruned();
  EXPECT_EQ(extractOccupiedVoxels(*map, 517).size(), 517);
  EXPECT_THROW(extractOccupiedVoxels(*map, 516), std::length_error);
}

TEST(ExtractOccupiedVoxels, RefusesAHugeLeafBeforeTakingMemoryForIt) {
  // 2^48 voxels: were they expanded, this test would not come to its end.
  EXPECT_THROW(extractOccupiedVoxels(*rootLeaf(kOccupied)), std::length_error);
  EXPECT_EQ(extractOccupiedVoxels(*rootLeaf(kFree)).size(), 0);
}

TEST(ExtractOccupiedVoxels, RefusesMoreVoxelsThanAMapOfSoFewNodesCanHave) {
  const auto leafAt = [](unsigned depth) {
    auto tree = rootLeaf(kOccupied);
    auto* node = tree->getRoot();
    for (unsigned d = 0; d < depth; d++) node = tree->createNodeChild(node, d == 0 ? 7 : 0);
    node->setLogOdds(kOccupied);
    return tree;
  };
  EXPECT_THROW(extractOccupiedVoxels(*leafAt(8)), std::length_error);  // 16.8 million voxels
  EXPECT_EQ(extractOccupiedVoxels(*leafAt(9)).size(), 2'097'152);
}

// ---------------------------------------------------------------- known space

TEST(KnownSpace, IsTheBoxOfAllLeavesAsOctomapHasIt) {
  const auto map =
      MapWriter(0.2).voxel({-3, 7, 2}, kOccupied).box({0, -9, 0}, {15, 6, 15}, kFree).pruned();
  Eigen::Vector3d low, high;
  map->getMetricMin(low.x(), low.y(), low.z());
  map->getMetricMax(high.x(), high.y(), high.z());
  const auto known = mrpt::fusion::knownSpace(*map);
  EXPECT_LT((known.min() - low).norm(), 1e-9);
  EXPECT_LT((known.max() - high).norm(), 1e-9);
  EXPECT_NEAR(known.min().x(), -0.6, 1e-9);
  EXPECT_DOUBLE_EQ(mrpt::fusion::knownSpace(*rootLeaf(kFree)).max().z(), 0.1 * 32768);
  EXPECT_TRUE(mrpt::fusion::knownSpace(octomap::OcTree(0.1)).isEmpty());
}

}  // namespace
}  // namespace mrpt::fusion::test::voxels_test
