// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of counts and entropies of a map. */
#include <gtest/gtest.h>
#include <mrpt/fusion/voxels.h>

#include <cmath>
#include <cstddef>

#include "support/test_maps.h"

namespace mrpt::fusion::test::statistics_test {
namespace {

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

TEST(MapStatistics, GoByTheMapsOwnOccupancyThreshold) {
  auto map = MapWriter().voxel({0, 0, 0}, 0.5F).voxel({1, 0, 0}, 2.F).unpruned();
  EXPECT_EQ(statisticsOf(*map).occupied, 2);
  map->setOccupancyThres(0.7);
  const MapStatistics s = statisticsOf(*map);
  EXPECT_EQ(s.occupied, 1);
  EXPECT_EQ(s.free, 1);
  EXPECT_NEAR(s.mean_entropy_occupied, binaryEntropy(1 / (1 + std::exp(-2.0))), 1e-7);
}

}  // namespace
}  // namespace mrpt::fusion::test::statistics_test
