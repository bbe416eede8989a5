// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the directions that walls and floors face. */
#include "fusion_core/search/wall_directions.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "support/test_maps.h"

namespace mrpt::fusion::test::wall_directions_test {
namespace {

// ---------------------------------------------------------------- directions of one map

TEST(DominantDirections, AreThoseOfMostSurface) {
  Surfaces surfaces;
  const Eigen::Matrix3d R = poseOf(0, 0, 0, 30, 20, 50).linear();
  const auto add = [&](const Eigen::Vector3d& n, size_t count, float weight) {
    for (size_t i = 0; i < count; i++) {
      const double sign = i % 2 == 0 ? 1 : -1;  // the sign of a normal says nothing
      surfaces.normal.push_back((sign * (R * n)).cast<float>());
      surfaces.weight.push_back(weight);
    }
  };
  add(Eigen::Vector3d::UnitX(), 300, 1);
  add(Eigen::Vector3d::UnitZ(), 200, 3);
  add(Eigen::Vector3d::UnitY(), 100, 1);
  add(Eigen::Vector3d(1, 1, 0).normalized(), 10, 1);  // too few
  add(Eigen::Vector3d::Zero(), 500, 1);               // no surface
  const auto found = dominantDirections(surfaces, 5, {});
  ASSERT_EQ(found.size(), 3U);
  for (size_t i = 0; i < 3; i++)
    EXPECT_NEAR(std::abs(found[i].dot(R.col(std::array{2, 0, 1}[i]))), 1, 1e-6) << i;
  EXPECT_EQ(dominantDirections(surfaces, 1, {}).size(), 1U);
  EXPECT_TRUE(dominantDirections({}, 3, {}).empty());
}

// ---------------------------------------------------------------- walls along walls

constexpr double kStep = 1 * kDegree;
using Normals = std::vector<Eigen::Vector3f>;

/** Normals of walls that face these headings, deg, so many of each, either way. */
Normals wallsFacing(const std::vector<double>& headings, size_t count = 100) {
  Normals normals;
  for (const double heading : headings)
    for (size_t i = 0; i < count; i++) {
      const double h = (heading + (i % 2 == 0 ? 0 : 180)) * kDegree;
      normals.emplace_back(static_cast<float>(std::cos(h)), static_cast<float>(std::sin(h)), 0.F);
    }
  return normals;
}

bool arePlausible(const WallDirections& walls, double yaw) {
  return walls.arePlausible(yaw * kDegree, kStep);
}

TEST(WallDirections, ArePlausibleWhereWallsLieAlongWalls) {
  const WallDirections walls(wallsFacing({0.5}), wallsFacing({-29.5}), kIdentity, 0.25);
  EXPECT_TRUE(arePlausible(walls, 30));
  EXPECT_TRUE(arePlausible(walls, 30 + 180)) << "normals have no sign";
  EXPECT_TRUE(arePlausible(walls, 30 - 360));
  for (const double yaw : {0.0, 15.0, 45.0, 120.0, -30.0})
    EXPECT_FALSE(arePlausible(walls, yaw)) << yaw;
}

TEST(WallDirections, OfRightAngledRoomsArePlausibleInFourWays) {
  const WallDirections walls(wallsFacing({0.5, 90.5}), wallsFacing({20.5, 110.5}), kIdentity, 0.25);
  for (const double yaw : {-20.0, 70.0, 160.0, 250.0}) EXPECT_TRUE(arePlausible(walls, yaw)) << yaw;
  for (const double yaw : {0.0, 25.0, 115.0, -65.0}) EXPECT_FALSE(arePlausible(walls, yaw)) << yaw;
}

TEST(WallDirections, CountFromTheGuess) {
  const WallDirections walls(wallsFacing({0.5}), wallsFacing({-29.5}), poseOf(1, 2, 3, 20), 0.25);
  EXPECT_TRUE(arePlausible(walls, 10)) << "of the 30 deg the guess has 20";
  EXPECT_FALSE(arePlausible(walls, 30));
}

TEST(WallDirections, ACoarseStepCoversWhatLiesWithinHalfOfIt) {
  const WallDirections walls(wallsFacing({0.5}), wallsFacing({-29.5}), kIdentity, 0.25);
  EXPECT_FALSE(walls.arePlausible(20 * kDegree, 2 * kDegree));
  EXPECT_TRUE(walls.arePlausible(20 * kDegree, 20 * kDegree));
}

TEST(WallDirections, FloorsSayNothing) {
  Normals with_floor = wallsFacing({0.5});
  for (int i = 0; i < 10000; i++) with_floor.emplace_back(0.1F, 0.3F, 0.95F);
  const WallDirections walls(with_floor, wallsFacing({-29.5}), kIdentity, 0.25);
  EXPECT_TRUE(arePlausible(walls, 30));
  EXPECT_FALSE(arePlausible(walls, 100));
}

TEST(WallDirections, WithoutWallsAllArePlausible) {
  const Normals floor(100, Eigen::Vector3f::UnitZ());
  const WallDirections walls(floor, floor, kIdentity, 0.25);
  for (int yaw = -180; yaw <= 180; yaw += 15) EXPECT_TRUE(arePlausible(walls, yaw)) << yaw;
}

}  // namespace
}  // namespace mrpt::fusion::test::wall_directions_test
