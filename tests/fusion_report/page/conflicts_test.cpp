// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the conflicts in a picture. */

#include "fusion_report/page/conflicts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "support/tree_tools.h"

using namespace mrpt::fusion;
using namespace map_tests;

namespace {

constexpr double kResolution = 0.1;

bool isOccupied(const VoxelMap& voxels, const VoxelIndex& at) {
  const auto v = voxels.find(at);
  return v != voxels.end() && v->second >= 0;
}

/** True if a point is in free space with no occupied voxel among the 27 around it. */
bool conflicts(const VoxelMap& other, const Eigen::Vector3d& p) {
  VoxelIndex at{};
  for (unsigned axis = 0; axis < 3; axis++)
    at[axis] = static_cast<int>(std::floor(p[axis] / kResolution));
  if (!other.count(at)) return false;
  for (int x = -1; x <= 1; x++)
    for (int y = -1; y <= 1; y++)
      for (int z = -1; z <= 1; z++)
        if (isOccupied(other, {at[0] + x, at[1] + y, at[2] + z})) return false;
  return true;
}

std::set<VoxelIndex> placesOf(const PageCubes& cubes) {
  std::set<VoxelIndex> places;
  for (const PageCube& c : cubes.cubes) {
    EXPECT_EQ(c.cube.depth, OcTreeCube::kMaxDepth);
    places.insert(
        {c.cube.key[0] - kOriginKey, c.cube.key[1] - kOriginKey, c.cube.key[2] - kOriginKey});
  }
  return places;
}

TEST(Conflicts, AreOccupiedVoxelsInTheFreeSpaceOfAnotherMap) {
  const auto a = sceneTree(kResolution, 1), b = sceneTree(kResolution, 2),
             c = sceneTree(kResolution, 3);
  Eigen::Isometry3d T_b_a = Eigen::Isometry3d::Identity(), T_c_a = T_b_a;
  T_b_a.translate(Eigen::Vector3d(0.313, 0.123, -0.071));
  T_b_a.rotate(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
  T_c_a.translate(Eigen::Vector3d(-0.507, 0.223, 0.037));
  const VoxelMap of_a = voxelsOf(*a), of_b = voxelsOf(*b), of_c = voxelsOf(*c);
  std::set<VoxelIndex> with_b, with_both;
  for (const auto& [at, log_odds] : of_a) {
    if (log_odds < 0) continue;
    const Eigen::Vector3d p =
        kResolution * (Eigen::Vector3d(at[0], at[1], at[2]).array() + 0.5).matrix();
    if (conflicts(of_b, T_b_a * p)) with_b.insert(at);
    if (conflicts(of_b, T_b_a * p) || conflicts(of_c, T_c_a * p)) with_both.insert(at);
  }
  ASSERT_GT(with_b.size(), 50U);
  ASSERT_GT(with_both.size(), with_b.size());
  EXPECT_EQ(placesOf(conflictingCubes(*a, {{b.get(), T_b_a}})), with_b);
  EXPECT_EQ(placesOf(conflictingCubes(*a, {{b.get(), T_b_a}, {c.get(), T_c_a}})), with_both);
  EXPECT_TRUE(conflictingCubes(*a, {}).cubes.empty());
}

TEST(Conflicts, DoNotExpandALargeLeaf) {
  octomap::OcTree large(kResolution), other(kResolution);
  putLeaf(large, {0, 0, 0}, 3, 2);  // 2^39 voxels
  putLeaf(other, {0, 0, 0}, 3, -1);
  const PageCubes conflicts_of_large =
      conflictingCubes(large, {{&other, Eigen::Isometry3d::Identity()}});
  EXPECT_EQ(conflicts_of_large.cubes.size(), 64U);
}

TEST(Conflicts, TakeAPoseOutsideOfTheGrid) {
  octomap::OcTree map(kResolution);
  putVoxel(map, {0, 0, 0}, 2);
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation().x() = 1e8;
  EXPECT_TRUE(conflictingCubes(map, {{&map, far}}).cubes.empty());
}

}  // namespace
