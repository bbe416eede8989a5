// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of what a map says of a point, against OctoMap's own search. */
#include "fusion_core/map/occupancy_query.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "support/matching_tools.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::occupancy_query_test {
namespace {

/** What OctoMap knows of a voxel. */
enum class Known { Nothing, Free, Occupied };

Known knownOf(const octomap::OcTree& map, const octomap::OcTreeKey& key) {
  const auto* node = map.search(key);
  if (!node) return Known::Nothing;
  return map.isNodeOccupied(node) ? Known::Occupied : Known::Free;
}

/** The twin of checkObstacle(): by the voxel and the 26 around it. */
ObstacleCheck checkByOctomap(const octomap::OcTree& map, const Eigen::Vector3d& p) {
  const octomap::OcTreeKey at = map.coordToKey(p.x(), p.y(), p.z());
  for (int dx = -1; dx <= 1; dx++)
    for (int dy = -1; dy <= 1; dy++)
      for (int dz = -1; dz <= 1; dz++) {
        const auto key = [](octomap::key_type k, int d) {
          return static_cast<octomap::key_type>(k + d);
        };
        if (knownOf(map, {key(at[0], dx), key(at[1], dy), key(at[2], dz)}) == Known::Occupied)
          return ObstacleCheck::Confirmed;
      }
  return knownOf(map, at) == Known::Free ? ObstacleCheck::Conflicting : ObstacleCheck::Unknown;
}

TEST(OccupancyQuery, SaysWhatOctomapKnowsOfTheVoxelAndThoseAround) {
  const auto map = randomTree();
  const MapVoxels voxels(borrowed(*map));
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place(-8, 8);
  std::map<ObstacleCheck, int> times;
  for (int i = 0; i < 20000; i++) {
    const Eigen::Vector3d p(place(random), place(random), place(random));
    const ObstacleCheck check = checkObstacle(voxels, p);
    ASSERT_EQ(check, checkByOctomap(*map, p)) << p.transpose();
    ASSERT_EQ(isFree(voxels, p), knownOf(*map, map->coordToKey(p.x(), p.y(), p.z())) == Known::Free)
        << p.transpose();
    times[check]++;
  }
  for (const ObstacleCheck f :
       {ObstacleCheck::Unknown, ObstacleCheck::Confirmed, ObstacleCheck::Conflicting})
    EXPECT_GT(times[f], 100) << static_cast<int>(f);
}

TEST(OccupancyQuery, AnObstacleInANeighbouringVoxelAgrees) {
  const auto map =
      MapWriter(0.2).box({0, 0, 0}, {9, 9, 9}, kFree).voxel({4, 4, 4}, kOccupied).pruned();
  const MapVoxels voxels(borrowed(*map));
  EXPECT_EQ(checkObstacle(voxels, centreOf({4, 4, 4}, 0.2)), ObstacleCheck::Confirmed);
  EXPECT_EQ(checkObstacle(voxels, centreOf({3, 5, 3}, 0.2)), ObstacleCheck::Confirmed)
      << "across a corner";
  EXPECT_EQ(checkObstacle(voxels, centreOf({2, 4, 4}, 0.2)), ObstacleCheck::Conflicting);
  EXPECT_EQ(checkObstacle(voxels, centreOf({-1, 4, 4}, 0.2)), ObstacleCheck::Unknown);
}

TEST(OccupancyQuery, NothingIsKnownBeyondTheOctreesReach) {
  const auto map = MapWriter().box({0, 0, 0}, {9, 9, 9}, kFree).pruned();
  const MapVoxels voxels(borrowed(*map));
  for (const double far : {1e5, -1e5}) {
    EXPECT_EQ(checkObstacle(voxels, {far, 0, 0}), ObstacleCheck::Unknown);
    EXPECT_FALSE(isFree(voxels, {0, far, 0}));
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::occupancy_query_test
