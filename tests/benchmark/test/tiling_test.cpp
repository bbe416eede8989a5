// SPDX-License-Identifier: BSD-3-Clause
#include "../tiling.h"

#include <gtest/gtest.h>
#include <mrpt/fusion/voxels.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "fusion_octree/resampling.h"
#include "support/test_maps.h"

namespace mrpt::fusion::benchmark {
namespace {

using test::Cell;
using test::MapWriter;

/** Off the blocks on all sides, with pruned free space and voxels of different log-odds. */
MapWriter someRoom() {
  MapWriter map;
  map.box({-37, 5, -3}, {11, 40, 18}, test::kFree).shell({-37, 5, -3}, {11, 40, 18}, 3.5F);
  for (int i = 0; i < 20; i++) map.voxel({i - 30, 10 + i, i % 7}, 0.1F * static_cast<float>(i));
  return map;
}

size_t knownVoxels(const octomap::OcTree& map) {
  const MapStatistics s = statisticsOf(map);
  return s.occupied + s.free;
}

/** Expects each voxel of a map in another, moved by so many voxels, with the same log-odds. */
void expectCopyAt(const octomap::OcTree& map, const octomap::OcTree& tiled, const Cell& shift) {
  for (auto leaf = map.begin_leafs(), end = map.end_leafs(); leaf != end; ++leaf) {
    const int side = 1 << (16 - leaf.getDepth());
    const octomap::OcTreeKey low = leaf.getIndexKey();
    for (int x = 0; x < side; x++)
      for (int y = 0; y < side; y++)
        for (int z = 0; z < side; z++) {
          const auto* node = tiled.search(
              test::keyOf({low[0] - 32768 + x + shift[0], low[1] - 32768 + y + shift[1],
                           low[2] - 32768 + z + shift[2]}));
          ASSERT_NE(node, nullptr);
          ASSERT_EQ(node->getLogOdds(), leaf->getLogOdds());  // bit for bit
        }
  }
}

TEST(BenchmarkTiling, EachCopyHoldsTheVoxelsOfTheMapAndNothingElse) {
  const auto map = someRoom().pruned();
  const auto other = MapWriter().box({-40, 20, 0}, {15, 50, 2}, test::kOccupied).pruned();
  constexpr uint32_t kX = 3, kY = 2;
  const Tiles tiles = tilesFor(*map, *other, kX, kY);
  EXPECT_GE(tiles.period[0], 56U);  // of both maps together
  EXPECT_GE(tiles.period[1], 46U);
  for (const auto* one : {map.get(), other.get()}) {
    const auto tiled = tileMap(*one, tiles);
    for (uint32_t x = 0; x < kX; x++)
      for (uint32_t y = 0; y < kY; y++)
        expectCopyAt(
            *one, *tiled,
            {static_cast<int>(x * tiles.period[0]), static_cast<int>(y * tiles.period[1]), 0});
    EXPECT_EQ(knownVoxels(*tiled), size_t{kX} * kY * knownVoxels(*one));
    EXPECT_EQ(tiled->size(), tiled->calcNumNodes());
  }
}

TEST(BenchmarkTiling, OneCopyIsTheMap) {
  const auto map = someRoom().pruned();
  EXPECT_TRUE(*tileMap(*map, tilesFor(*map, *map, 1, 1)) == *map);
}

TEST(BenchmarkTiling, CopiesThatDoNotFitAreRefused) {
  const auto map = someRoom().pruned();
  EXPECT_THROW(tilesFor(*map, *map, 1000, 1), std::out_of_range);
}

TEST(BenchmarkTiling, MapBIsCopiedInTheFrameOfMapA) {
  std::string folder = std::filesystem::temp_directory_path() / "tiling_test.XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  MapPair pair;
  pair.folder = folder;
  pair.a = someRoom().pruned();
  pair.b = someRoom().pruned();
  // A quarter turn and whole voxels: B is resampled without loss, and its copies follow each other
  // along its own -y where A's follow each other along x.
  pair.T_a_b.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  pair.T_a_b.translation() << 0.4, -0.7, 0.2;
  std::ofstream(folder + "/T_a_b.txt") << pair.T_a_b.matrix();

  const std::string out = folder + "/tiled";
  writeTiledPair(pair, 2, 1, out);
  const MapPair tiled = loadMapPair(out);
  EXPECT_TRUE(tiled.T_a_b.isApprox(pair.T_a_b, 1e-12));
  const auto b_in_a = mrpt::fusion::transformOcTree(*pair.b, pair.T_a_b, 0.1);
  const int period = static_cast<int>(tilesFor(*pair.a, *b_in_a, 2, 1).period[0]);
  expectCopyAt(*pair.a, *tiled.a, {period, 0, 0});
  expectCopyAt(*pair.b, *tiled.b, {0, 0, 0});
  expectCopyAt(*pair.b, *tiled.b, {0, -period, 0});
  EXPECT_EQ(knownVoxels(*tiled.b), 2 * knownVoxels(*pair.b));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace mrpt::fusion::benchmark
