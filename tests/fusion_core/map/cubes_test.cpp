// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the known space as arrays of cubes. */
#include <gtest/gtest.h>
#include <mrpt/fusion/voxels.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include "fusion_octree/files.h"
#include "fusion_octree/walk.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::cubes_test {
namespace {

std::unique_ptr<octomap::OcTree> mapOfManySizes() {
  return MapWriter(0.2)
      .box({16, -16, 0}, {31, -1, 15}, kOccupied)
      .box({-64, -64, -64}, {-33, -33, -33}, kFree)
      .box({40, 0, 0}, {47, 6, 2}, 0.8F)
      .voxel({-3, 7, 2}, kFree)
      .pruned();
}

std::string messageOf(const Cubes& cubes) {
  try {
    octreeOf(cubes);
  } catch (const std::exception& e) {
    return e.what();
  }
  return {};
}

TEST(CubesOf, HasEachLeafInTheOrderOfTheOctree) {
  const auto map = mapOfManySizes();
  const Cubes cubes = cubesOf(*map);
  EXPECT_EQ(cubes.resolution, 0.2);
  ASSERT_EQ(cubes.count(), map->getNumLeafNodes());
  size_t i = 0;
  for (auto leaf = map->begin_leafs(); leaf != map->end_leafs(); ++leaf, ++i) {
    const octomap::point3d centre = leaf.getCoordinate();
    ASSERT_EQ(cubes.centre[i], Eigen::Vector3f(centre.x(), centre.y(), centre.z()));
    ASSERT_EQ(cubes.log_odds[i], leaf->getLogOdds());
    ASSERT_EQ(cubes.size[i], static_cast<float>(leaf.getSize()));
  }
}

TEST(CubesOf, SeparatesOccupiedFromFreeSpace) {
  const auto map = mapOfManySizes();
  const Cubes occupied = cubesOf(*map, KnownSpace::Occupied),
              free = cubesOf(*map, KnownSpace::Free);
  EXPECT_EQ(occupied.count() + free.count(), map->getNumLeafNodes());
  EXPECT_EQ(free.count(), 2U);
  for (const float log_odds : free.log_odds) EXPECT_EQ(log_odds, kFree);
  for (const float log_odds : occupied.log_odds) EXPECT_GT(log_odds, 0);
}

TEST(CubesOf, DoesNotDependOnThreads) {
  const auto map = randomTree();
  const Cubes many = cubesOf(*map);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Cubes single = cubesOf(*map);
  EXPECT_EQ(many.centre, single.centre);
  EXPECT_EQ(many.log_odds, single.log_odds);
  EXPECT_EQ(many.size, single.size);
}

TEST(CubesOf, TakesEmptyMapsAndMapsOfOneLeaf) {
  octomap::OcTree map(0.1);
  EXPECT_EQ(cubesOf(map).count(), 0U);
  Cubes whole;
  whole.resolution = 0.1;
  whole.centre = {{0, 0, 0}};
  whole.log_odds = {kFree};
  whole.size = {6553.6F};
  const auto one_leaf = octreeOf(whole);
  EXPECT_EQ(one_leaf->size(), 1U);
  EXPECT_EQ(cubesOf(*one_leaf).size, whole.size);
}

TEST(OctreeOf, InvertsCubesOfInAnyOrder) {
  for (const auto& map : {mapOfManySizes(), octreeOf(cubesOf(*randomTree()))}) {
    Cubes cubes = cubesOf(*map);
    EXPECT_EQ(toOtFile(*octreeOf(cubes)), toOtFile(*map));
    std::mt19937 random(1);
    for (size_t i = cubes.count() - 1; i > 0; i--) {
      const size_t k = random() % (i + 1);
      std::swap(cubes.centre[i], cubes.centre[k]);
      std::swap(cubes.log_odds[i], cubes.log_odds[k]);
      std::swap(cubes.size[i], cubes.size[k]);
    }
    EXPECT_EQ(toOtFile(*octreeOf(cubes)), toOtFile(*map));
  }
}

TEST(OctreeOf, FindsVoxelsOfAllSizesAtTheEndOfTheGrid) {
  for (const double resolution : {1e-4, 0.03, 0.1, 7.3, 1e6}) {
    MapWriter writer(resolution);
    for (const int end : {-32768, -1, 0, 32767})
      writer.voxel({end, -end - 1, end}, 0.01F * static_cast<float>(end)).voxel({end, end, end}, 1);
    const auto map = writer.pruned();
    EXPECT_EQ(toOtFile(*octreeOf(cubesOf(*map))), toOtFile(*map)) << resolution;
  }
}

TEST(OctreeOf, TakesVoxelsWithoutSizesAndPrunesThem) {
  Cubes cubes;
  cubes.resolution = 1;
  for (const float x : {0.2F, 1.7F})
    for (const float y : {0.5F, 1.5F})
      for (const float z : {0.9F, 1.1F}) cubes.centre.emplace_back(x, y, z);
  cubes.log_odds.assign(8, 1.25F);
  EXPECT_EQ(octreeOf(cubes)->getNumLeafNodes(), 1U);
}

TEST(OctreeOf, NamesTheFirstFault) {
  Cubes good;
  good.resolution = 0.5;
  good.centre = {{0.25F, 0.25F, 0.25F}, {1.5F, 0.5F, 0.5F}};
  good.log_odds = {1, -1};
  good.size = {0.5F, 1.0F};
  EXPECT_EQ(messageOf(good), "");

  Cubes c = good;
  c.size = {0.5F};
  EXPECT_EQ(messageOf(c), "centres, log-odds and sizes are not of the same number");
  c = good;
  c.size[1] = 0.75F;
  EXPECT_EQ(messageOf(c),
            "cube 1 has a size that is not the voxel size times a power of 2 up to 65536");
  c.size[1] = -1;
  EXPECT_EQ(messageOf(c),
            "cube 1 has a size that is not the voxel size times a power of 2 up to 65536");
  c = good;
  c.centre[0].y() = 16385;
  EXPECT_EQ(messageOf(c), "cube 0 is outside the grid of an octree");
  c.centre[0].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(messageOf(c), "cube 0 is outside the grid of an octree");
  c = good;
  c.log_odds[1] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(messageOf(c), "cube 1 has log-odds that are not finite");
  c = good;
  c.centre[1] = {0.3F, 0.3F, 0.3F};
  EXPECT_EQ(messageOf(c), "cube 1 overlaps cube 0");
  c = good;
  c.resolution = 0;
  EXPECT_NE(messageOf(c), "");
}

}  // namespace
}  // namespace mrpt::fusion::test::cubes_test
