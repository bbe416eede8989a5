// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the choice of voxels that stand for those around them. */
#include "fusion_core/features/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "fusion_octree/resampling.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::thinning_test {
namespace {

/** Of a map whose walls lie across its grid. Made once, for the tests only read them. */
const OccupiedVoxels& voxelsOfAMap() {
  static const OccupiedVoxels voxels = extractOccupiedVoxels(*mrpt::fusion::transformOcTree(
      *apartment({0, 0, 0}, {65, 69, 25}), poseOf(-1.7, -4.5, -0.53, 23, 1, -0.5), 0.1));
  return voxels;
}

TEST(Thinning, ThinnedOutMapsHaveOneVoxelOfEachCube) {
  const OccupiedVoxels& all = voxelsOfAMap();
  const Thinned few = thinOut(all, 0.4);
  using Cube = std::array<int, 3>;
  const auto cubeOf = [](const octomap::OcTreeKey& k) {
    return Cube{k[0] / 4, k[1] / 4, k[2] / 4};
  };
  std::map<Cube, size_t> best;  // by hand: in each cube the most probable
  std::map<Cube, int> count;
  for (size_t i = 0; i < all.size(); i++) {
    const auto [it, is_first] = best.try_emplace(cubeOf(all.key[i]), i);
    if (!is_first && all.probability[i] > all.probability[it->second]) it->second = i;
    count[it->first]++;
  }
  ASSERT_EQ(few.index.size(), best.size());
  EXPECT_TRUE(std::is_sorted(few.index.begin(), few.index.end()));
  for (size_t k = 0; k < few.index.size(); k++) {
    const Cube cube = cubeOf(all.key[few.index[k]]);
    EXPECT_EQ(few.index[k], best.at(cube));
    EXPECT_EQ(few.weight[k], count.at(cube));
  }
  EXPECT_EQ(thinOut(all, 0.1).index.size(), all.size());
}

TEST(Thinning, ThinningTakesTheVoxelThatIsAskedFor) {
  const OccupiedVoxels& all = voxelsOfAMap();
  const Thinned last = thinOut(all, 0.4, [](uint32_t, uint32_t) { return true; });
  ASSERT_GT(last.index.size(), 100U);
  size_t end = 0;  // where the cube after each one begins
  for (size_t k = 0; k < last.index.size(); k++) {
    end += static_cast<size_t>(last.weight[k]);
    EXPECT_EQ(last.index[k], end - 1);
  }
  EXPECT_EQ(end, all.size());
}

TEST(Thinning, ThinnedOutMapsHaveOneVoxelOfEachCubeOfAPrunedLeaf) {
  // One leaf of 8 voxels' side, and a neighbour that is not pruned.
  const auto tree =
      MapWriter(0.1).box({0, 0, 0}, {7, 7, 7}, kOccupied).voxel({9, 1, 1}, kOccupied).pruned();
  EXPECT_EQ(tree->getNumLeafNodes(), 2U);
  EXPECT_EQ(thinOut(extractOccupiedVoxels(*tree), 0.4).index.size(), 9U);
}

// ---------------------------------------------------------------- few of many

/** Voxels in a row, each with a normal or without. */
SurfaceVoxels rowOf(const std::vector<bool>& has_normal) {
  std::vector<Cell> cells;
  for (int x = 0; x < static_cast<int>(has_normal.size()); x++) cells.push_back({x, 0, 0});
  SurfaceVoxels row{voxelsAt(cells, 0.1), {}};
  for (const bool flat : has_normal) {
    row.surfaces.normal.emplace_back(0.F, 0.F, flat ? 1.F : 0.F);
    row.surfaces.point.push_back(row.voxels.centre[row.surfaces.point.size()]);
    row.surfaces.variation.push_back(0.01F * static_cast<float>(row.surfaces.variation.size()));
    row.surfaces.weight.push_back(1);
  }
  return row;
}

TEST(FewOf, PrefersVoxelsThatHaveANormal) {
  SurfaceVoxels row = rowOf({false, true, false, true, true, false, true, true});
  row.voxels.probability = {0.9F, 0.6F, 0.95F, 0.7F, 0.6F, 0.99F, 0.8F, 0.7F};
  const SurfaceVoxels few = fewOf(row, 0.4, 0);
  ASSERT_EQ(few.voxels.size(), 2U) << "one of each cube of four";
  EXPECT_EQ(few.voxels.key[0], keyOf({3, 0, 0})) << "the most probable that has a normal";
  EXPECT_EQ(few.voxels.key[1], keyOf({6, 0, 0}));
  EXPECT_EQ(few.surfaces.variation[0], row.surfaces.variation[3]) << "its own surface";
  EXPECT_EQ(few.surfaces.variation[1], row.surfaces.variation[6]);
}

TEST(FewOf, TakesTheMostProbableVoxelIfNoneHasANormal) {
  SurfaceVoxels row = rowOf({false, false, false, false});
  row.voxels.probability = {0.6F, 0.8F, 0.9F, 0.7F};
  const SurfaceVoxels few = fewOf(row, 0.4, 0);
  ASSERT_EQ(few.voxels.size(), 1U);
  EXPECT_EQ(few.voxels.key[0], keyOf({2, 0, 0}));
}

TEST(FewOf, TakesNoMoreThanEnoughSpreadOverAll) {
  const SurfaceVoxels row = rowOf(std::vector<bool>(100, true));
  for (const size_t enough : {1, 7, 50, 99, 100, 1000}) {
    const SurfaceVoxels few = fewOf(row, 0.1, enough);
    EXPECT_LE(few.voxels.size(), enough);
    EXPECT_GE(2 * few.voxels.size(), std::min<size_t>(enough, 100)) << enough;
    EXPECT_EQ(few.surfaces.normal.size(), few.voxels.size());
  }
  const SurfaceVoxels four = fewOf(row, 0.1, 4);
  EXPECT_EQ(four.voxels.key,
            (std::vector<octomap::OcTreeKey>{keyOf({0, 0, 0}), keyOf({25, 0, 0}), keyOf({50, 0, 0}),
                                             keyOf({75, 0, 0})}));
}

TEST(Select, GivesTheVoxelsAskedForInTheirOrder) {
  const OccupiedVoxels all = voxelsAt({{0, 0, 0}, {5, 1, 2}, {7, 7, 7}}, 0.2);
  const OccupiedVoxels some = select(all, {2, 0});
  EXPECT_EQ(some.resolution, 0.2);
  ASSERT_EQ(some.size(), 2U);
  EXPECT_EQ(some.key[0], all.key[2]);
  EXPECT_EQ(some.key[1], all.key[0]);
  EXPECT_EQ(some.centre[0], all.centre[2]);
  EXPECT_EQ(select(all, {}).size(), 0U);
}

}  // namespace
}  // namespace mrpt::fusion::test::thinning_test
