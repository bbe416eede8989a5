// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of slices: they are compared with a loop over all voxels. */
#include "fusion_octree/slice.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <string>
#include <utility>

#include "fusion_octree/walk.h"
#include "support/tree_tools.h"

namespace mrpt::fusion {
namespace {

using map_tests::putLeaf;
using map_tests::putVoxel;
using octomap::OcTree;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/** Returns the highest log-odds of each column, by the centre of the column in cells. */
std::map<std::pair<int, int>, float> columnsOf(const OcTree& map, double low, double high) {
  std::map<std::pair<int, int>, float> columns;
  forEachLeaf(map, [&](const OcTreeCube& cube, const octomap::OcTreeNode& node) {
    forEachVoxel(cube, [&](const octomap::OcTreeKey& key) {
      const double z = map.keyToCoord(key[2]);
      if (z < low || z > high) return;
      const auto column = columns.try_emplace({key[0] - 32768, key[1] - 32768}, node.getLogOdds());
      column.first->second = std::max(column.first->second, node.getLogOdds());
    });
  });
  return columns;
}

void expectTwin(const OcTree& map, double low, double high) {
  const auto expected = columnsOf(map, low, high);
  const MapSlice slice = sliceOf(map, low, high);
  ASSERT_EQ(slice.log_odds.size(), slice.width * slice.height);
  size_t known = 0;
  for (size_t i = 0; i < slice.log_odds.size(); i++) {
    if (slice.log_odds[i] == MapSlice::kUnknown) continue;
    known++;
    const double x = slice.low_x / slice.resolution + static_cast<double>(i % slice.width);
    const double y = slice.low_y / slice.resolution + static_cast<double>(i / slice.width);
    const auto column =
        expected.find({static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))});
    ASSERT_NE(column, expected.end()) << "at " << x << " " << y;
    ASSERT_EQ(slice.log_odds[i], column->second) << "at " << x << " " << y;
  }
  EXPECT_EQ(known, expected.size());
}

TEST(MapSlice, IsThatOfALoopOverAllVoxels) {
  for (const double resolution : {0.05, 0.1, 0.3}) {
    const auto scene = map_tests::sceneTree(resolution, 3);
    expectTwin(*scene, -kInfinity, kInfinity);
    for (int bottom = -12; bottom < 14; bottom += 3)
      for (int size = 1; size < 12; size += 5)
        expectTwin(*scene, bottom * resolution, (bottom + size) * resolution);
  }
}

TEST(MapSlice, HasTheBoxOfTheKnownVoxelsBetweenTheHeights) {
  OcTree map(0.5);
  putVoxel(map, {2, -3, 0}, -1);
  putVoxel(map, {4, 1, 1}, 2);
  putVoxel(map, {-50, 70, 5}, 2);
  map_tests::finish(map);
  const MapSlice slice = sliceOf(map, 0, 1);
  EXPECT_EQ(slice.width, 3U);
  EXPECT_EQ(slice.height, 5U);
  EXPECT_DOUBLE_EQ(slice.low_x, 1);
  EXPECT_DOUBLE_EQ(slice.low_y, -1.5);
  EXPECT_EQ(slice.log_odds.front(), -1.0F);
  EXPECT_EQ(slice.log_odds.back(), 2.0F);
  EXPECT_EQ(slice.log_odds[1], MapSlice::kUnknown);
}

TEST(MapSlice, HoldsVoxelsWhoseCentreIsOnAHeight) {
  OcTree map(0.1);
  for (int z = 0; z < 10; z++) putVoxel(map, {z, 0, z}, static_cast<float>(z + 1));
  map_tests::finish(map);
  EXPECT_EQ(sliceOf(map, 0.15, 0.35).width, 3U);
  EXPECT_EQ(sliceOf(map, 0.151, 0.349).width, 1U);
  EXPECT_EQ(sliceOf(map, 0.35, 0.35).width, 1U);
}

TEST(MapSlice, OfUnknownSpaceIsEmpty) {
  const auto scene = map_tests::sceneTree(0.1, 3);
  for (const auto& [low, high] : std::vector<std::pair<double, double>>{
           {100, 200}, {0.11, 0.12}, {-1e9, -1e8}, {1e8, kInfinity}}) {
    EXPECT_TRUE(sliceOf(*scene, low, high).log_odds.empty()) << low;
  }
  EXPECT_TRUE(sliceOf(OcTree(0.1), -kInfinity, kInfinity).log_odds.empty());
}

TEST(MapSlice, OfFarVoxelsIsRejected) {
  OcTree map(0.1);
  putVoxel(map, {-30000, -30000, 0}, 1);
  putVoxel(map, {30000, 30000, 0}, 1);
  map_tests::finish(map);
  EXPECT_NE(map_tests::errorOf([&] { sliceOf(map, -1, 1); }).find("cells"), std::string::npos);
  putLeaf(map, {0, 0, 16384}, 2, -1);
  EXPECT_NE(map_tests::errorOf([&] { sliceOf(map, 1639, kInfinity); }), "");
}

TEST(MapSlice, OfLargeLeavesAboveEachOtherTakesTheTimeOfOne) {
  // 128 layers of leaves of 64 x 64 x 64 voxels: one by one they are 1.1e9 cells.
  OcTree map(0.1);
  for (int z = 0; z < 128; z++)
    for (int y = 0; y < 46; y++)
      for (int x = 0; x < 46; x++)
        putLeaf(map, {64 * x, 64 * y, 64 * z - 4096}, 10, (x + y + z) % 97 == 0 ? 1.0F : -1.0F);
  map_tests::finish(map);
  const MapSlice slice = sliceOf(map, -kInfinity, kInfinity);
  EXPECT_EQ(slice.width * slice.height, size_t{46} * 46 * 64 * 64);
  for (int y = 0; y < 46; y++)
    for (int x = 0; x < 46; x++) {
      bool occupied = false;
      for (int z = 0; z < 128; z++) occupied = occupied || (x + y + z) % 97 == 0;
      ASSERT_EQ(slice.log_odds[static_cast<size_t>(64 * y + 5) * slice.width + 64 * x + 5],
                occupied ? 1.0F : -1.0F);
    }
}

TEST(CellThresholds, SayWhatACellIs) {
  const CellThresholds wide{-1, 2};
  EXPECT_EQ(wide.kindOf(MapSlice::kUnknown), CellKind::Unknown);
  EXPECT_EQ(wide.kindOf(-1.5F), CellKind::Free);
  EXPECT_EQ(wide.kindOf(-1), CellKind::Unknown);
  EXPECT_EQ(wide.kindOf(1.9F), CellKind::Unknown);
  EXPECT_EQ(wide.kindOf(2), CellKind::Occupied);
  OcTree map(0.1);
  EXPECT_EQ(CellThresholds::of(map).kindOf(0), CellKind::Occupied);
  EXPECT_EQ(CellThresholds::of(map).kindOf(-0.01F), CellKind::Free);
}

}  // namespace
}  // namespace mrpt::fusion
