// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_octree/voxel_hash.h"

#include <gtest/gtest.h>

#include "support/tree_tools.h"

namespace mrpt::fusion::test::voxel_hash_test {
namespace {

using map_tests::putLeaf;
using map_tests::putVoxel;
using map_tests::sceneTree;
using octomap::OcTree;

TEST(VoxelHash, IsTheSameForTheSameVoxelsPrunedOrNot) {
  const auto map = sceneTree(0.1, 1);
  OcTree expanded(*map);
  expanded.expand();
  expanded.getRoot()->setLogOdds(0.25F);
  ASSERT_GT(expanded.size(), map->size());
  EXPECT_EQ(voxelHash(*map), voxelHash(expanded));
}

TEST(VoxelHash, DiffersIfAVoxelDiffers) {
  const auto map = sceneTree(0.1, 1);
  EXPECT_NE(voxelHash(*map), voxelHash(*sceneTree(0.1, 2)));
  EXPECT_NE(voxelHash(*map), voxelHash(*sceneTree(0.2, 1)));
  OcTree other(0.1), moved(0.1), cube(0.1), empty(0.1);
  putVoxel(other, {0, 0, 0}, 1.F);
  putVoxel(moved, {1, 0, 0}, 1.F);
  putLeaf(cube, {0, 0, 0}, 15, 1.F);
  EXPECT_NE(voxelHash(other), voxelHash(moved));
  EXPECT_NE(voxelHash(other), voxelHash(cube));
  EXPECT_NE(voxelHash(other), voxelHash(empty));
  OcTree signed_zero(0.1), zero(0.1);
  putVoxel(signed_zero, {0, 0, 0}, -0.F);
  putVoxel(zero, {0, 0, 0}, 0.F);
  EXPECT_NE(voxelHash(signed_zero), voxelHash(zero));
}

TEST(VoxelHash, StaysTheSameInAllVersions) {
  // Files keep the hash: a change makes the sources in old files unknown.
  OcTree map(0.1);
  putVoxel(map, {0, 0, 0}, 1.F);
  putLeaf(map, {64, 0, 0}, 10, -2.F);
  EXPECT_EQ(voxelHash(map), 6934450464047293240U);
}

}  // namespace
}  // namespace mrpt::fusion::test::voxel_hash_test
