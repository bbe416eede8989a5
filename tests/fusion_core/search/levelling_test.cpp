// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the search for maps whose verticals differ. */
#include "fusion_core/search/levelling.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/features/thinning.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_octree/resampling.h"
#include "support/matching_tools.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::levelling_test {
namespace {

constexpr double kVoxel = 0.4;  // m

/** Level ground with free space above it, and boxes as of houses. Corners in voxels. */
std::unique_ptr<octomap::OcTree> village(const Cell& low, const Cell& high, int side = 200) {
  MapWriter map(kVoxel);
  map.within(low, high);
  map.box({0, 0, 1}, {side - 1, side - 1, 8}, -1);
  map.box({0, 0, 0}, {side - 1, side - 1, 0}, 2);
  std::mt19937 random(1);
  const auto upTo = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (int i = 0; i < side * side / 1000; i++) {
    const Cell corner{upTo(side - 20), upTo(side - 20), 0};
    map.shell(corner, {corner[0] + 5 + upTo(14), corner[1] + 5 + upTo(14), 4 + upTo(8)}, 2);
  }
  return map.unpruned();
}

SurfaceVoxels surfacesOf(const octomap::OcTree& map) {
  const OccupiedVoxels voxels = extractOccupiedVoxels(map);
  return {voxels, computeSurfaces(voxels, {})};
}

double degreesBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::min(1.0, a.dot(b))) * 180 / M_PI;
}

class Levelling : public testing::Test {
 protected:
  static const octomap::OcTree& whole() {
    static const auto map = village({0, 0, 0}, {199, 199, 20});
    return *map;
  }
  static std::unique_ptr<octomap::OcTree> tiltedPart(const Eigen::Isometry3d& T) {
    return transformOcTree(*village({20, 40, 0}, {170, 199, 20}), T, kVoxel);
  }
  const LevellingParams params{};
};

TEST_F(Levelling, TheGroundShowsUp) {
  for (const Eigen::Isometry3d& T : {poseOf(0, 0, 0, 30), poseOf(3, 0, 1, 0, 5, 0),
                                     poseOf(0, 0, 0, 100, -3, 4), poseOf(0, 0, 0, 0, 12, -9)}) {
    const Eigen::Vector3d up = upDirection(surfacesOf(*tiltedPart(T)), params);
    EXPECT_LT(degreesBetween(up, T.linear().col(2)), 0.5) << T.matrix();
  }
}

TEST_F(Levelling, WithoutGroundZIsUp) {
  MapWriter wall(kVoxel);
  wall.box({0, 0, 0}, {0, 99, 30}, 2);
  EXPECT_EQ(upDirection(surfacesOf(*wall.unpruned()), params), Eigen::Vector3d::UnitZ());
  EXPECT_EQ(upDirection({}, params), Eigen::Vector3d::UnitZ());
  // A strip has no slope across it.
  MapWriter strip(kVoxel);
  strip.box({0, 0, 0}, {99, 3, 0}, 2);
  EXPECT_EQ(upDirection(surfacesOf(*strip.unpruned()), params), Eigen::Vector3d::UnitZ());
}

TEST_F(Levelling, ATiltedMapIsFound) {
  const Eigen::Isometry3d T_b_a = poseOf(10, -20, 2, 140, 5, -6);
  const auto part = tiltedPart(T_b_a);
  const MapVoxels a(borrowed(whole()));
  const SurfaceVoxels of_a = surfacesOf(whole()), of_b = surfacesOf(*part);
  const SearchParams search = everywhere({});
  const Eigen::Vector3d middle = meanOf(of_b.voxels.centre);
  const auto found = searchLevelled(a, of_a, of_b, of_b, kIdentity, search);
  ASSERT_FALSE(found.empty());
  EXPECT_LE(found.size(), search.hypotheses);
  EXPECT_LT((found[0].T_a_b * middle - T_b_a.inverse() * middle).norm(), 1.5);
  EXPECT_LT(test::degreesBetween(found[0].T_a_b, T_b_a.inverse()), 2);
  // The search without levelling keeps the tilt.
  const auto tilted = searchAround(a, of_a.surfaces, of_b, kIdentity, search);
  ASSERT_FALSE(tilted.empty());
  EXPECT_GT(test::degreesBetween(tilted[0].T_a_b, T_b_a.inverse()), 5);
  EXPECT_GT(found[0].score, tilted[0].score);
}

TEST_F(Levelling, AMapIsFoundIfTheGroundOfItsPartHasASlopeOfItsOwn) {
  constexpr int kSide = 480;  // 192 m
  const auto town = village({0, 0, 0}, {kSide - 1, kSide - 1, 20}, kSide);
  const auto part = village({0, 200, 0}, {kSide - 1, kSide - 1, 20}, kSide);
  const MapVoxels a(borrowed(*town));
  const SurfaceVoxels of_a = surfacesOf(*town);
  const auto tilted = [&](const Eigen::Isometry3d& T) {
    return surfacesOf(*transformOcTree(*part, T, kVoxel));
  };
  const Eigen::Isometry3d T_b_a = poseOf(10, -20, 2, 30, 5, -3);
  const SurfaceVoxels all_of_b = tilted(T_b_a);
  const SurfaceVoxels of_b = fewOf(all_of_b, 0.8, 1000);
  const Eigen::Vector3d middle = meanOf(of_b.voxels.centre);
  for (const double slope : {-3.0, 3.0}) {
    // The verticals are measured on other surfaces than those of the search.
    const SurfaceVoxels ground = tilted(poseOf(0, 0, 0, 0, slope) * T_b_a);
    const auto found = searchLevelled(a, of_a, ground, of_b, kIdentity, everywhere({}));
    ASSERT_FALSE(found.empty());
    EXPECT_LT((found[0].T_a_b * middle - T_b_a.inverse() * middle).norm(), 2) << slope;
    EXPECT_LT(test::degreesBetween(found[0].T_a_b, T_b_a.inverse()), 2) << slope;
  }
}

TEST_F(Levelling, LevelMapsAreSearchedOnce) {
  const auto part = village({20, 40, 0}, {170, 199, 20});
  const MapVoxels a(borrowed(whole()));
  const SurfaceVoxels of_a = surfacesOf(whole()), of_b = surfacesOf(*part);
  const auto found = searchLevelled(a, of_a, of_b, of_b, kIdentity, everywhere({}));
  const auto once = searchAround(a, of_a.surfaces, of_b, kIdentity, everywhere({}));
  ASSERT_EQ(found.size(), once.size());
  for (size_t i = 0; i < found.size(); i++)
    EXPECT_EQ(found[i].T_a_b.matrix(), once[i].T_a_b.matrix());
}

}  // namespace
}  // namespace mrpt::fusion::test::levelling_test
