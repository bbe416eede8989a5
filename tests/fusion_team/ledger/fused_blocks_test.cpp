// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_team/ledger/fused_blocks.h"

#include <gtest/gtest.h>

#include "support/test_maps.h"
#include "support/tree_tools.h"

namespace mrpt::fusion::test::fused_blocks_test {
namespace {

using map_tests::putVoxel;
using octomap::OcTree;

std::shared_ptr<const OcTree> oneVoxel(const map_tests::VoxelIndex& where, float log_odds) {
  auto map = std::make_shared<OcTree>(0.1);
  putVoxel(*map, where, log_odds);
  return map;
}

TEST(TouchedSpace, HoldsTheBlocksOfAMap) {
  TouchedSpace touched;
  EXPECT_TRUE(touched.empty());
  touched.add(*oneVoxel({20, 0, 0}, 1.F));
  touched.add(*oneVoxel({0, 0, 0}, 1.F));
  touched.add(*oneVoxel({1, 2, 3}, 1.F));
  touched.finish();
  const auto share = [&](const map_tests::VoxelIndex& v, unsigned depth) {
    return touched.shareOf({map_tests::keyOf(v), depth});
  };
  EXPECT_EQ(share({0, 0, 0}, 12), TouchedSpace::Share::All);
  EXPECT_EQ(share({15, 15, 15}, 16), TouchedSpace::Share::All);
  EXPECT_EQ(share({16, 0, 0}, 12), TouchedSpace::Share::All);
  EXPECT_EQ(share({32, 0, 0}, 12), TouchedSpace::Share::None);
  EXPECT_EQ(share({0, 16, 0}, 12), TouchedSpace::Share::None);
  EXPECT_EQ(share({0, 0, 0}, 11), TouchedSpace::Share::Part);
  EXPECT_EQ(touched.shareOf({}), TouchedSpace::Share::Part);
}

TEST(TouchedSpace, HoldsAMapOfOneHugeLeaf) {
  TouchedSpace touched, all;
  touched.add(*rootLeaf(1.F));
  touched.finish();
  all.addAll();
  EXPECT_EQ(touched.shareOf({}), TouchedSpace::Share::All);
  EXPECT_EQ(all.shareOf({}), TouchedSpace::Share::All);
}

TEST(CombineOcTrees, ComputesOnlyTouchedBlocks) {
  // The earlier result holds values that no map has, so that copies can be seen.
  const auto map = std::make_shared<OcTree>(0.1);
  OcTree before(0.1);
  for (const int x : {-20, 0, 15, 16, 200}) {
    putVoxel(*map, {x, 0, 0}, 1.F);
    putVoxel(before, {x, 0, 0}, -1.F);
  }
  TouchedSpace touched;
  touched.add(*oneVoxel({3, 3, 3}, 1.F));
  touched.finish();
  const auto fused = combineOcTrees({map}, 1, {}, OcTreeAccess::sensorModel(*map), before, touched);
  const map_tests::VoxelMap expected = {{{-20, 0, 0}, -1.F},
                                        {{0, 0, 0}, 1.F},
                                        {{15, 0, 0}, 1.F},
                                        {{16, 0, 0}, -1.F},
                                        {{200, 0, 0}, -1.F}};
  EXPECT_TRUE(map_tests::sameVoxels(map_tests::voxelsOf(*fused), expected));
}

TEST(CombineOcTrees, CombinesHugeLeavesWithSmallVoxels) {
  TouchedSpace all;
  all.addAll();
  const OcTree none(0.1);
  const auto fused = combineOcTrees({rootLeaf(-1.F), oneVoxel({5, 6, 7}, 3.F)}, 2, {},
                                    OcTreeAccess::sensorModel(none), none, all);
  EXPECT_EQ(fused->search(keyOf({5, 6, 7}))->getLogOdds(), 2.F);
  EXPECT_EQ(fused->search(keyOf({5, 6, 8}))->getLogOdds(), -1.F);
  EXPECT_EQ(fused->search(keyOf({-32768, 0, 0}))->getLogOdds(), -1.F);
}

}  // namespace
}  // namespace mrpt::fusion::test::fused_blocks_test
