// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the scale of a map. */
#include "fusion_core/map/map_scale.h"

#include <gtest/gtest.h>

namespace mrpt::fusion::test::map_scale_test {
namespace {

/** Voxels that fill a box evenly, in steps of 1/20 of its sides. */
OccupiedVoxels box(double resolution, const Eigen::Vector3d& sides) {
  constexpr int kSteps = 20;
  OccupiedVoxels voxels;
  voxels.resolution = resolution;
  for (int x = 0; x <= kSteps; x++)
    for (int y = 0; y <= kSteps; y++)
      for (int z = 0; z <= kSteps; z++) {
        voxels.centre.push_back(
            (Eigen::Vector3d(x, y, z).cwiseProduct(sides) / kSteps).cast<float>());
        voxels.probability.push_back(0.9F);
      }
  return voxels;
}

TEST(MapScale, OfBuildingsAtUsualVoxelsIsOne) {
  for (const double voxel : {0.05, 0.1, 0.2})
    for (const double side : {3.0, 30.0}) EXPECT_EQ(scaleOf(box(voxel, {side, side, 3}), {}), 1);
}

TEST(MapScale, GrowsWithLargeVoxels) {
  EXPECT_DOUBLE_EQ(scaleOf(box(0.6, {200, 200, 20}), {}), 3);
  EXPECT_DOUBLE_EQ(scaleOf(box(1, {5, 5, 5}), {}), 5);
}

TEST(MapScale, OfSmallVoxelsDependsOnTheScene) {
  EXPECT_NEAR(scaleOf(box(0.01, {4, 2, 1}), {}), 0.4, 0.05);   // the extent of 4 m over 10 m
  EXPECT_NEAR(scaleOf(box(0.02, {2, 2, 1}), {}), 0.4, 1e-12);  // the voxels: 0.02 m over 0.05 m
  EXPECT_EQ(scaleOf(box(0.02, {30, 20, 3}), {}), 1);           // a building stays a building
}

TEST(MapScale, IgnoresStrayReturns) {
  OccupiedVoxels desk = box(0.01, {2, 2, 1});
  const double without = scaleOf(desk, {});
  for (int i = 0; i < 50; i++) {
    desk.centre.emplace_back(100.F + static_cast<float>(i), 0.F, 0.F);
    desk.probability.push_back(0.9F);
  }
  EXPECT_NEAR(scaleOf(desk, {}), without, 0.02);
}

TEST(MapScale, OfAnEmptyMapIsOneAndAFixedScaleHolds) {
  EXPECT_EQ(scaleOf({}, {}), 1);
  ScaleParams params;
  params.fixed = 2.5;
  EXPECT_EQ(scaleOf(box(0.1, {30, 30, 3}), params), 2.5);
}

}  // namespace
}  // namespace mrpt::fusion::test::map_scale_test
