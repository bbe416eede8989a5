// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/fusion/statistics.h>
#include <mrpt/fusion/voxels.h>

#include <cmath>
#include <map>
#include <stdexcept>

#include "fusion_core/map/free_space.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_octree/build.h"
#include "fusion_octree/walk.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test {
namespace {

using Key = std::array<uint16_t, 3>;

/** Probability by key: what a set of voxels is, whatever its order. */
std::map<Key, float> byKey(const OccupiedVoxels& v) {
  std::map<Key, float> m;
  for (size_t i = 0; i < v.size(); i++)
    m[{v.key[i][0], v.key[i][1], v.key[i][2]}] = v.probability[i];
  return m;
}

/** A map of one leaf, at the root. */
std::unique_ptr<octomap::OcTree> rootLeaf(float log_odds) {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  mrpt::fusion::OcTreeAccess::createRoot(*tree)->setLogOdds(log_odds);
  return tree;
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

// ---------------------------------------------------------------- entropy and statistics

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

TEST(BinaryEntropy, ByHand) {
  EXPECT_DOUBLE_EQ(binaryEntropy(0.5), std::log(2.0));
  EXPECT_NEAR(binaryEntropy(0.9), 0.325083, 1e-6);
  EXPECT_DOUBLE_EQ(binaryEntropy(0.9), binaryEntropy(1 - 0.9));
  EXPECT_EQ(binaryEntropy(0), 0);
  EXPECT_EQ(binaryEntropy(1), 0);
}

TEST(MapStatistics, CountsPrunedLeavesAsTheVoxelsTheyStandFor) {
  const float nine_tenths = std::log(9.F);
  const auto map = MapWriter()
                       .box({0, 0, 0}, {1, 1, 1}, nine_tenths)   // one leaf, 8 voxels, p = 0.9
                       .voxel({2, 0, 0}, 0.F)                    // p = 0.5: occupied
                       .box({4, 0, 0}, {7, 3, 3}, -nine_tenths)  // one leaf, 64 voxels, p = 0.1
                       .pruned();
  ASSERT_EQ(map->getNumLeafNodes(), 3);
  const MapStatistics s = statisticsOf(*map);
  EXPECT_EQ(s.occupied, 9);
  EXPECT_EQ(s.free, 64);
  const double h = 0.32508297339144826, ln2 = std::log(2.0);
  EXPECT_NEAR(s.mean_entropy_occupied, (8 * h + ln2) / 9, 1e-7);
  EXPECT_NEAR(s.mean_entropy_known, (72 * h + ln2) / 73, 1e-7);
}

TEST(MapStatistics, OfAnEmptyMapAreZero) {
  const MapStatistics s = statisticsOf(octomap::OcTree(0.1));
  EXPECT_EQ(s.occupied + s.free, 0);
  EXPECT_EQ(s.mean_entropy_occupied, 0);
  EXPECT_EQ(s.mean_entropy_known, 0);
}

TEST(MapStatistics, CountAHugeLeafWithoutExpandingIt) {
  EXPECT_EQ(statisticsOf(*rootLeaf(kOccupied)).occupied, size_t{1} << 48U);
}

}  // namespace
}  // namespace mrpt::fusion::test
