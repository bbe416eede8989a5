// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of how well two maps agree at a pose. */
#include "fusion_core/verdict/agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "support/apartment_pair.h"
#include "support/matching_tools.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::agreement_test {
namespace {

const ApartmentPair& maps() {
  static const ApartmentPair pair(0.2);
  return pair;
}

TEST(Agreement, IsHighestAtTheTruth) {
  const auto& [a, b] = std::tie(maps().a, maps().b);
  const Eigen::Isometry3d truth = maps().truth;
  const Obstacles of_a = obstaclesOf(a, a.matched), of_b = obstaclesOf(b, b.matched);
  const double best = agreement(a, of_a, b, of_b, truth);
  for (const auto& off : {poseOf(0.5, 0, 0, 0), poseOf(0, -0.5, 0, 0), poseOf(0, 0, 0.4, 0),
                          poseOf(0, 0, 0, 5), poseOf(2, 1, 0, 10), poseOf(40, 0, 0, 0)})
    EXPECT_LT(agreement(a, of_a, b, of_b, truth * off), best) << off.matrix();
}

// ---------------------------------------------------------------- by hand

/** A map and its voxels. */
struct Map {
  explicit Map(std::unique_ptr<octomap::OcTree> map) : tree(std::move(map)) {}

  const std::unique_ptr<octomap::OcTree> tree;
  const MapVoxels voxels{borrowed(*tree)};
};

/** A wall at x = 0.5 m with air before it, 10 voxels each way; behind it all is unknown. */
Map wallAndAir() {
  return Map(
      MapWriter().box({0, 0, 0}, {4, 9, 9}, kFree).box({5, 0, 0}, {5, 9, 9}, kOccupied).pruned());
}

Obstacles obstaclesAt(const std::vector<Cell>& cells,
                      const Eigen::Vector3f& front = Eigen::Vector3f::Zero()) {
  return {voxelsAt(cells, 0.1).centre, std::vector<Eigen::Vector3f>(cells.size(), front)};
}

/** What the wall's map says of obstacles of a map that says nothing itself. */
double agreementWithWall(const Obstacles& obstacles, const Eigen::Isometry3d& T = kIdentity,
                         const AgreementParams& params = {}) {
  static const Map wall = wallAndAir();
  static const Map other(MapWriter().voxel({100, 100, 100}, kOccupied).pruned());
  return agreement(wall.voxels, {}, other.voxels, obstacles, T, params);
}

TEST(Agreement, IsTheNumberOfConfirmedObstaclesIfNoneConflicts) {
  EXPECT_EQ(agreementWithWall(obstaclesAt({{5, 1, 1}, {5, 5, 5}, {6, 3, 3}})), 3);
  EXPECT_EQ(agreementWithWall(obstaclesAt({{5, 1, 1}, {50, 0, 0}})), 1) << "unknown says nothing";
  EXPECT_EQ(agreementWithWall({}), 0);
}

TEST(Agreement, IsWhereThePosePutsTheObstacles) {
  const Eigen::Isometry3d T = poseOf(0.5, -0.2, 0.1, 90);
  Obstacles moved = obstaclesAt({{5, 5, 5}});
  moved.centre[0] = (T.inverse() * moved.centre[0].cast<double>()).cast<float>();
  EXPECT_EQ(agreementWithWall(moved, T), 1);
  EXPECT_EQ(agreementWithWall(moved), 0);
}

TEST(Agreement, ConflictsTakeItAwayByTheirShare) {
  std::vector<Cell> cells;
  for (int y = 0; y < 9; y++) cells.push_back({5, y, 5});
  cells.push_back({2, 5, 5});  // in the air
  AgreementParams params;
  for (const double tolerance : {0.02, 0.1}) {
    params.tolerance = tolerance;
    EXPECT_NEAR(agreementWithWall(obstaclesAt(cells), kIdentity, params),
                9 * std::exp(-0.1 / tolerance), 1e-12);
  }
  EXPECT_EQ(agreementWithWall(obstaclesAt({{2, 5, 5}})), 0) << "nothing is confirmed";
}

TEST(Agreement, AConflictAtTheBorderOfTheFreeSpaceCountsInPart) {
  const Map wall = wallAndAir(), other(MapWriter().voxel({100, 100, 100}, kOccupied).pruned());
  const auto agreementOf = [&](const Cell& conflict, const BorderParams& border) {
    std::vector<Cell> cells{conflict};
    for (int y = 0; y < 9; y++) cells.push_back({5, y, 5});
    return agreement(wall.voxels, {}, other.voxels, obstaclesAt(cells), kIdentity, {}, border);
  };
  const auto expected = [](double weight) { return 9 * std::exp(-weight / (9 + weight) / 0.02); };
  const BorderParams half{0.5, 0.1};
  for (const Cell& at_border : {Cell{0, 5, 5}, {2, 0, 5}, {2, 5, 9}})
    EXPECT_NEAR(agreementOf(at_border, half), expected(0.5), 1e-12);
  EXPECT_NEAR(agreementOf({2, 5, 5}, half), expected(1), 1e-12) << "free space all around";
  EXPECT_NEAR(agreementOf({0, 5, 5}, {0.5, 0.09}), expected(1), 1e-12) << "the voxels are larger";
}

TEST(Agreement, AnObstacleSeenFromTheOtherSideCountsInPart) {
  AgreementParams params;
  params.other_side = 0.3;
  const auto facing = [&](float x) {
    return agreementWithWall(obstaclesAt({{5, 5, 5}}, {x, 0, 0}), kIdentity, params);
  };
  EXPECT_EQ(facing(-1), 1) << "towards the air";
  EXPECT_EQ(facing(1), 0.3) << "away from it";
  EXPECT_EQ(facing(0), 1) << "from both sides, or not known";
}

TEST(Agreement, AsksBothMaps) {
  const Map a = wallAndAir(), b = wallAndAir();
  const Obstacles three = obstaclesAt({{5, 1, 1}, {5, 5, 5}, {5, 8, 2}}),
                  one = obstaclesAt({{5, 4, 4}});
  EXPECT_EQ(agreement(a.voxels, three, b.voxels, one, kIdentity), 4);
  // 0.3 m further b's obstacle lies in unknown space of a, and those of a in the air of b.
  EXPECT_EQ(agreement(a.voxels, three, b.voxels, one, poseOf(0.3, 0, 0, 0)), 0);
  EXPECT_EQ(agreement(a.voxels, three, b.voxels, {}, poseOf(0.1, 0, 0, 0)), 3)
      << "beside an obstacle";
}

TEST(ConfirmedFromSameSide, CountsNoObstacleSeenFromTheOtherSide) {
  const Map a = wallAndAir(), b = wallAndAir();
  const auto facing = [](float x) {
    return obstaclesAt({{5, 1, 1}, {5, 5, 5}, {5, 8, 2}}, {x, 0, 0});
  };
  const auto count = [&](const Obstacles& of_a, const Obstacles& of_b) {
    return confirmedFromSameSide(a.voxels, of_a, b.voxels, of_b, kIdentity);
  };
  EXPECT_EQ(count(facing(-1), facing(-1)), 6U) << "both maps, towards the air";
  EXPECT_EQ(count(facing(-1), facing(1)), 3U) << "those of B are seen from behind";
  EXPECT_EQ(count(facing(1), facing(1)), 0U);
  EXPECT_EQ(count(facing(0), {}), 3U) << "the side is not known";
}

TEST(ObstaclesOf, FaceTheAirBeforeThem) {
  const Map wall = wallAndAir();
  for (const float normal : {-1.F, 1.F}) {
    SurfaceVoxels one{voxelsAt({{5, 5, 5}}, 0.1), {}};
    one.surfaces.normal = {Eigen::Vector3f(normal, 0, 0)};
    const Obstacles o = obstaclesOf(wall.voxels, one);
    EXPECT_EQ(o.centre, one.voxels.centre);
    EXPECT_EQ(o.front, (std::vector<Eigen::Vector3f>{{-1, 0, 0}})) << normal;
  }
}

TEST(ObstaclesOf, SeenFromBothSidesOrNoneHaveNoFront) {
  const Map between(
      MapWriter().box({0, 0, 0}, {10, 9, 9}, kFree).box({5, 0, 0}, {5, 9, 9}, kOccupied).pruned());
  const Map alone(MapWriter().box({5, 0, 0}, {5, 9, 9}, kOccupied).pruned());
  SurfaceVoxels one{voxelsAt({{5, 5, 5}}, 0.1), {}};
  one.surfaces.normal = {Eigen::Vector3f::UnitX()};
  EXPECT_TRUE(obstaclesOf(between.voxels, one).front[0].isZero(0));
  EXPECT_TRUE(obstaclesOf(alone.voxels, one).front[0].isZero(0));
}

}  // namespace
}  // namespace mrpt::fusion::test::agreement_test
