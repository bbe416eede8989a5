// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the grid that scores many poses, against the map's voxels one by one. */
#include "fusion_core/search/score_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include "fusion_octree/walk.h"
#include "support/matching_tools.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::score_grid_test {
namespace {

using Values = std::map<Cell, uint16_t>;  // of cells that are not unknown

/** A map of 3.2 m around the origin: sparse obstacles, free space in leaves of all sizes. */
std::unique_ptr<octomap::OcTree> scatteredMap() {
  std::mt19937 random(8);
  MapWriter map(0.1);
  const auto place = [&] { return static_cast<int>(random() % 28) - 14; };
  for (int i = 0; i < 12; i++) {
    const Cell c{place(), place(), place()};
    const int side = 1 << (random() % 4);
    map.within({-16, -16, -16}, {15, 15, 15})
        .box(c, {c[0] + side, c[1] + side, c[2] + side}, kFree);
  }
  map.box({-16, -16, -16}, {-1, -1, -1}, kFree);
  for (int i = 0; i < 20; i++) map.voxel({place(), place(), place()}, kOccupied);
  return map.pruned();
}

/** The twin: what each cell says, from the voxels in it. A cell beside an occupied cell says
 * nothing. */
Values valuesByVoxel(const octomap::OcTree& map, unsigned level) {
  Values values;
  const auto cellOf = [&](const octomap::OcTreeKey& key) {
    Cell c{};
    for (unsigned axis = 0; axis < 3; axis++) {
      const int from_origin = static_cast<int>(key[axis]) - 32768;
      c[axis] = static_cast<int>(std::floor(from_origin / std::ldexp(1., static_cast<int>(level))));
    }
    return c;
  };
  forEachLeaf(map, [&](const OcTreeCube& leaf, const auto& node) {
    forEachVoxel(leaf, [&](const octomap::OcTreeKey& key) {
      uint16_t& v = values.try_emplace(cellOf(key), ScoreGrid::kFree).first->second;
      if (map.isNodeOccupied(node)) v = ScoreGrid::kOccupied;
    });
  });
  const Values before = values;
  for (const auto& [cell, value] : before) {
    if (value != ScoreGrid::kOccupied) continue;
    for (int dx = -1; dx <= 1; dx++)
      for (int dy = -1; dy <= 1; dy++)
        for (int dz = -1; dz <= 1; dz++) {
          const auto beside = values.find({cell[0] + dx, cell[1] + dy, cell[2] + dz});
          if (beside != values.end() && beside->second == ScoreGrid::kFree) values.erase(beside);
        }
  }
  return values;
}

uint16_t valueOf(const Values& values, const Cell& c) {
  const auto found = values.find(c);
  return found == values.end() ? ScoreGrid::kUnknown : found->second;
}

uint16_t valueOf(const ScoreGrid& grid, const Cell& c) {
  std::vector<uint16_t> sums(static_cast<size_t>(ScoreGrid::padded(1)), 0);
  grid.addBox(c, {1, 1, 1}, sums.data());
  return sums[0];
}

ScoreGrid gridOf(const octomap::OcTree& map, unsigned level) {
  const MapVoxels voxels(borrowed(map));
  const double cell = map.getResolution() * (1U << level);
  return ScoreGrid(voxels, knownSpace(map), {cell, level});
}

TEST(ScoreGrid, SaysOfEachCellWhatItsVoxelsSay) {
  const auto map = scatteredMap();
  for (const unsigned level : {0U, 1U, 2U, 3U}) {
    const ScoreGrid grid = gridOf(*map, level);
    const Values expected = valuesByVoxel(*map, level);
    std::map<uint16_t, int> times;
    for (int x = -20; x < 20; x++)
      for (int y = -20; y < 20; y++)
        for (int z = -20; z < 20; z++) {
          const uint16_t v = valueOf(grid, {x, y, z});
          ASSERT_EQ(v, valueOf(expected, {x, y, z})) << level << ": " << x << "," << y << "," << z;
          times[v]++;
        }
    EXPECT_EQ(times.size(), level < 3 ? 3U : 2U) << "of each kind, but in the largest cells";
  }
}

TEST(ScoreGrid, AddsTheValuesOfABoxOfCells) {
  const auto map = scatteredMap();
  const ScoreGrid grid = gridOf(*map, 0);
  const Values values = valuesByVoxel(*map, 0);
  std::mt19937 random(9);
  int not_zero = 0;
  for (int i = 0; i < 300; i++) {
    const auto from = [&] { return static_cast<int>(random() % 50) - 30; };
    const auto length = [&] { return 1 + static_cast<int>(random() % 20); };
    const Cell low{from(), from(), from()}, size{length(), length(), length()};
    const int row = ScoreGrid::padded(size[0]);
    const uint16_t before = static_cast<uint16_t>(random() % 100);
    std::vector<uint16_t> sums(static_cast<size_t>(row * size[1] * size[2]), before);
    const uint16_t times = 1 + random() % 3;
    for (int k = 0; k < times; k++) grid.addBox(low, size, sums.data());
    for (int z = 0; z < size[2]; z++)
      for (int y = 0; y < size[1]; y++)
        for (int x = 0; x < size[0]; x++) {
          const uint16_t value = valueOf(values, {low[0] + x, low[1] + y, low[2] + z});
          not_zero += value != 0;
          ASSERT_EQ(sums[static_cast<size_t>((z * size[1] + y) * row + x)], before + times * value)
              << i << ": " << x << "," << y << "," << z;
        }
  }
  EXPECT_GT(not_zero, 5000);
}

TEST(ScoreGrid, SumsKeepBothCountsApart) {
  const auto map =
      MapWriter(0.1).box({0, 0, 0}, {7, 7, 7}, kFree).voxel({0, 0, 0}, kOccupied).pruned();
  const ScoreGrid grid = gridOf(*map, 0);
  std::vector<uint16_t> sums(8, 0);
  for (size_t i = 0; i < 100; i++) grid.addBox({0, 0, 0}, {1, 1, 1}, sums.data());
  for (size_t i = 100; i < ScoreGrid::kMostSummed; i++)
    grid.addBox({5, 5, 5}, {1, 1, 1}, sums.data());
  EXPECT_EQ(sums[0] % ScoreGrid::kFree, 100);
  EXPECT_EQ(sums[0] / ScoreGrid::kFree, 155);
}

TEST(ScoreGrid, CoarserCellsAreOccupiedIfOneIsAndFreeIfAllAre) {
  const auto map = scatteredMap();
  for (const unsigned level : {0U, 1U}) {
    const ScoreGrid coarser = gridOf(*map, level).coarser();
    const Values fine = valuesByVoxel(*map, level);
    std::map<uint16_t, int> times;
    for (int x = -11; x < 11; x++)
      for (int y = -11; y < 11; y++)
        for (int z = -11; z < 11; z++) {
          int occupied = 0, free = 0;
          for (int i = 0; i < 8; i++) {
            const uint16_t v =
                valueOf(fine, {2 * x + (i & 1), 2 * y + (i >> 1 & 1), 2 * z + (i >> 2)});
            occupied += v == ScoreGrid::kOccupied;
            free += v == ScoreGrid::kFree;
          }
          const uint16_t expected = occupied > 0 ? ScoreGrid::kOccupied
                                    : free == 8  ? ScoreGrid::kFree
                                                 : ScoreGrid::kUnknown;
          ASSERT_EQ(valueOf(coarser, {x, y, z}), expected) << x << "," << y << "," << z;
          times[expected]++;
        }
    EXPECT_EQ(times.size(), 3U);
  }
}

TEST(ScoreGrid, IsUnknownOutsideOfItsRegion) {
  const auto map = MapWriter(0.1).box({-16, -16, -16}, {15, 15, 15}, kFree).pruned();
  const MapVoxels voxels(borrowed(*map));
  const ScoreGrid grid(
      voxels, {Eigen::Vector3d(-0.45, -0.45, -0.45), Eigen::Vector3d(0.45, 0.45, 0.45)}, {0.1, 0});
  EXPECT_EQ(valueOf(grid, {0, 0, 0}), ScoreGrid::kFree);
  EXPECT_EQ(valueOf(grid, {4, -5, 4}), ScoreGrid::kFree);
  EXPECT_EQ(valueOf(grid, {9, 0, 0}), ScoreGrid::kUnknown);
  EXPECT_EQ(valueOf(grid, {0, -12, 0}), ScoreGrid::kUnknown);
}

TEST(ScoreGrid, CellsOfPlacesAndOfVoxelsAreTheSame) {
  for (const unsigned level : {0U, 2U}) {
    const ScoreGrid::Layout layout{0.1 * (1U << level), level};
    for (const Cell& c : {Cell{0, 0, 0}, {-1, 3, 4}, {-17, 100, -4}})
      EXPECT_EQ(layout.cellOf(keyOf(c)), layout.cellOf(centreOf(c, 0.1)));
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::score_grid_test
