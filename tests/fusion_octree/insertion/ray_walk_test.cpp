// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the voxels of rays, compared with octomap::OcTree::computeRayKeys(). */
#include "fusion_octree/insertion/ray_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace mrpt::fusion {
namespace {

using octomap::OcTree;
using octomap::point3d;

using Keys = std::set<CellKey>;

/** Returns the free or the occupied voxels of marks. */
Keys keysOf(const CellMarks& marks, const CellWindow& window, bool occupied) {
  Keys keys;
  for (const uint64_t block : marks.numbers())
    for (unsigned i = 0; i < 4096; i++) {
      const BlockMarks& all = *marks.find(block);
      if (!((occupied ? all.occupied : all.free)[i / 64] >> (i % 64) & 1U)) continue;
      CellKey key = window.lowestOf(block);
      for (unsigned bit = 0; bit < 4; bit++)
        for (unsigned axis = 0; axis < 3; axis++)
          key[axis] += static_cast<int32_t>((i >> (3 * bit + axis) & 1U) << bit);
      EXPECT_EQ(window.number(key), block << 12U | i);
      keys.insert(key);
    }
  return keys;
}

CellKey keyOf(const octomap::OcTreeKey& key) { return {key[0], key[1], key[2]}; }

/** Compares the voxels of rays with octomap. */
void expectSameVoxels(double resolution, const point3d& origin, const std::vector<point3d>& ends,
                      RayWalker& walker) {
  const OcTree tree(resolution);
  Keys free, occupied;
  octomap::KeyRay ray;
  for (const auto& end : ends) {
    ASSERT_TRUE(tree.computeRayKeys(origin, end, ray));
    for (const auto& key : ray) free.insert(keyOf(key));
    occupied.insert(keyOf(tree.coordToKey(end)));
  }
  const RayOrigin from(tree, origin);
  RayChunk chunk;
  makeRays(ends.data(), ends.size(), from, -1, chunk);
  CellBox box = chunk.box;
  box.add({from.key, from.key});
  CellWindow window;
  ASSERT_TRUE(window.cover(box));
  CellMarks marks;
  marks.clear(window.blocks());
  ASSERT_TRUE(walker.walk(chunk, from, window, marks));
  ASSERT_EQ(keysOf(marks, window, false), free);
  ASSERT_EQ(keysOf(marks, window, true), occupied);
}

class RayWalk : public testing::TestWithParam<RayWalker::Lanes> {};
INSTANTIATE_TEST_SUITE_P(Lanes, RayWalk,
                         testing::Values(RayWalker::Lanes::Best, RayWalker::Lanes::Two));

TEST_P(RayWalk, MarksTheVoxelsOfOctomapRayByRay) {
  RayWalker walker(GetParam());
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(-3, 3);
  for (int i = 0; i < 3000; i++) {
    const point3d origin(place(random), place(random), place(random));
    expectSameVoxels(0.1, origin, {{place(random), place(random), place(random)}}, walker);
  }
}

TEST_P(RayWalk, MarksTheVoxelsOfOctomapIfEndsLieOnBordersOfVoxels) {
  // Rounding decides which voxels such rays cross, and some rays miss the voxel of their end.
  RayWalker walker(GetParam());
  std::mt19937 random(2);
  std::uniform_int_distribution<int> place(-40, 40);
  const auto point = [&](float unit) {
    return point3d(unit * static_cast<float>(place(random)),
                   unit * static_cast<float>(place(random)),
                   unit * static_cast<float>(place(random)));
  };
  for (const float unit : {0.1F, 0.05F, 0.025F})
    for (int i = 0; i < 1500; i++)
      expectSameVoxels(0.1, point(unit), {point(unit), point(unit), point(unit)}, walker);
}

TEST_P(RayWalk, MarksTheVoxelsOfOctomapForManyRaysOfAllLengths) {
  RayWalker walker(GetParam());
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-1, 1);
  for (const size_t count : {size_t{1}, size_t{8}, size_t{9}, RayChunk::kMost}) {
    std::vector<point3d> ends(count);
    for (size_t i = 0; i < count; i++)
      ends[i] = point3d(place(random), place(random), place(random)) *
                static_cast<float>(std::pow(0.97, i % 100) * 40);
    expectSameVoxels(0.1, {place(random), place(random), place(random)}, ends, walker);
  }
}

TEST_P(RayWalk, MarksNoFreeVoxelIfARayEndsInItsFirstVoxel) {
  RayWalker walker(GetParam());
  expectSameVoxels(0.1, {0.01F, 0.01F, 0.01F}, {{0.09F, 0.02F, 0.05F}, {0.01F, 0.01F, 0.01F}},
                   walker);
}

TEST(CellWindow, RefusesBoxesOfTooManyVoxels) {
  CellWindow window;
  EXPECT_TRUE(window.cover({{0, 0, 0}, {4000, 4000, 4000}}));
  EXPECT_FALSE(window.cover({{0, 0, 0}, {65535, 65535, 65535}}));
}

TEST(CellWindow, ContainsTheBoxAndKeysOfTheOctreeOnly) {
  CellWindow window;
  ASSERT_TRUE(window.cover({{0, 100, 65530}, {15, 131, 65535}}));
  EXPECT_TRUE(window.contains({0, 100, 65530}));
  EXPECT_TRUE(window.contains({17, 133, 65535}));
  EXPECT_FALSE(window.contains({-1, 100, 65530}));
  EXPECT_FALSE(window.contains({0, 100, 65536}));
  EXPECT_FALSE(window.contains({0, 300, 65530}));
}

}  // namespace
}  // namespace mrpt::fusion
