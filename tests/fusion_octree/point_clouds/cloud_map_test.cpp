// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of maps of point clouds: they are compared with maps of OctoMap, node by node. */
#include "fusion_octree/point_clouds/cloud_map.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <random>
#include <set>
#include <string>

#include "support/cloud_files.h"
#include "support/tree_tools.h"

namespace mrpt::fusion {
namespace {

using map_tests::errorOf;
using map_tests::Points;
using map_tests::sameTree;
using octomap::OcTree;
using octomap::point3d;

/** Returns the walls of a room around the origin, and a block of voxels that becomes one leaf. */
PointCloud room() {
  std::mt19937 rng(5);
  std::uniform_real_distribution<float> along(-4, 4), noise(-0.02F, 0.02F);
  PointCloud cloud;
  for (int i = 0; i < 20000; i++) {
    const double wall = 4 + noise(rng), u = along(rng), v = along(rng);
    switch (i % 3) {
      case 0:
        cloud.add(wall, u, v);
        break;
      case 1:
        cloud.add(u, -wall, v);
        break;
      default:
        cloud.add(u, v, -wall);
    }
  }
  for (int i = 0; i < 64; i++)
    cloud.add(0.05 + 0.1 * (i & 3), 0.05 + 0.1 * (i >> 2 & 3), 0.05 + 0.1 * (i >> 4));
  return cloud;
}

std::unique_ptr<OcTree> mapOf(const PointCloud& cloud, const std::optional<point3d>& origin,
                              double resolution = 0.1) {
  size_t outside = 0;
  auto map = octreeOf(cloud, origin, resolution, outside);
  EXPECT_EQ(outside, 0U);
  return map;
}

TEST(CloudMap, WithoutSensorHasOneHitPerVoxel) {
  for (const double resolution : {0.05, 0.1, 0.4}) {
    const PointCloud cloud = room();
    OcTree expected(resolution);
    std::set<std::array<unsigned, 3>> voxels;
    for (const auto& p : cloud.points) {
      const auto key = expected.coordToKey(p);
      if (voxels.insert({key[0], key[1], key[2]}).second) expected.updateNode(key, true, true);
    }
    expected.updateInnerOccupancy();
    expected.prune();
    EXPECT_TRUE(sameTree(expected, *mapOf(cloud, {}, resolution))) << resolution;
  }
}

TEST(CloudMap, WithSensorIsThatOfOctomap) {
  const PointCloud cloud = room();
  const point3d origin(-1, 1, -0.5F);
  OcTree expected(0.1);
  octomap::Pointcloud ends;
  for (const auto& p : cloud.points) ends.push_back(p);
  expected.insertPointCloud(ends, origin, -1, true);
  expected.updateInnerOccupancy();
  expected.prune();
  EXPECT_TRUE(sameTree(expected, *mapOf(cloud, origin)));
}

TEST(CloudMap, HasTheSameOccupiedVoxelsWithAndWithoutSensor) {
  const auto occupied = [](const OcTree& map) {
    OcTree copy(map);
    copy.expand();
    std::set<std::array<unsigned, 3>> keys;
    for (auto leaf = copy.begin_leafs(); leaf != copy.end_leafs(); ++leaf)
      if (copy.isNodeOccupied(*leaf)) {
        const auto key = leaf.getKey();
        keys.insert({key[0], key[1], key[2]});
      }
    return keys;
  };
  const PointCloud cloud = room();
  EXPECT_EQ(occupied(*mapOf(cloud, {})), occupied(*mapOf(cloud, point3d(-2, 0, 0))));
}

TEST(CloudMap, IsTheSameForAnyNumberOfThreads) {
  const PointCloud cloud = room();
  for (const auto& origin : {std::optional<point3d>(), std::optional<point3d>(point3d(0, 0, 0))}) {
    const auto many = mapOf(cloud, origin);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_TRUE(sameTree(*many, *mapOf(cloud, origin)));
  }
}

TEST(CloudMap, LeavesOutPointsOutsideOfTheGrid) {
  PointCloud cloud = room();
  const auto before = mapOf(cloud, point3d(0, 0, 0));
  cloud.add(1e30, 0, 0);
  cloud.add(0, -4000, 0);
  cloud.add(0, 0, 3276.9);
  size_t outside = 0;
  EXPECT_TRUE(sameTree(*before, *octreeOf(cloud, point3d(0, 0, 0), 0.1, outside)));
  EXPECT_EQ(outside, 3U);
}

TEST(CloudMap, MayBeEmpty) {
  EXPECT_EQ(mapOf({}, {})->size(), 0U);
  EXPECT_EQ(mapOf({}, point3d(0, 0, 0))->size(), 0U);
}

TEST(CloudMap, OfFarPointsWithASensorIsRejected) {
  PointCloud cloud;
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> place(-3000, 3000);
  for (int i = 0; i < 2000; i++) cloud.add(place(rng), place(rng), place(rng));
  EXPECT_NE(mapOf(cloud, {}), nullptr);
  const std::string reason = errorOf([&] { mapOf(cloud, point3d(0, 0, 0)); });
  EXPECT_NE(reason.find("the voxels are too small"), std::string::npos) << reason;
  EXPECT_NE(mapOf(cloud, point3d(0, 0, 0), 10), nullptr);
}

TEST(CloudMap, RejectsWrongParameters) {
  for (const double resolution : {0.0, -1.0, 1e-5, 1e7, std::nan("")})
    EXPECT_NE(errorOf([&] { mapOf(room(), {}, resolution); }), "") << resolution;
  EXPECT_NE(errorOf([&] { mapOf(room(), point3d(4000, 0, 0)); }), "");
  EXPECT_NE(errorOf([&] { mapOf(room(), point3d(std::nanf(""), 0, 0)); }), "");
}

TEST(CloudMap, OfAFileHasNotes) {
  Points points = room().points;
  points.emplace_back(std::nanf(""), 0, 0);
  points.emplace_back(1e20F, 0, 0);
  points.emplace_back(-1e20F, 0, 0);
  const auto noted = [&](const std::string& bytes, const CloudParams& params,
                         const std::string& part) {
    std::vector<std::string> notes;
    parseCloudMap(bytes, params, &notes);
    for (const auto& note : notes)
      if (note.find(part) != std::string::npos) return true;
    return false;
  };
  const std::string pcd = map_tests::pcdFile(points, "binary");
  EXPECT_TRUE(noted(pcd, {}, "1 point without finite coordinates"));
  EXPECT_TRUE(noted(pcd, {}, "2 points outside"));
  EXPECT_TRUE(noted(pcd, {}, "no free space"));
  EXPECT_FALSE(noted(pcd, {0.1, point3d(0, 0, 0)}, "no free space"));
  EXPECT_TRUE(noted(map_tests::plyFile(points, "ascii"), {}, "mesh"));
}

TEST(CloudMap, PrefersTheGivenSensorToTheViewpoint) {
  const PointCloud cloud = room();
  const std::string pcd = map_tests::pcdFile(cloud.points, "binary", "1 0 0 1 0 0 0");
  EXPECT_TRUE(sameTree(*mapOf(cloud, point3d(1, 0, 0)), *parseCloudMap(pcd, {})));
  const point3d given(0, 2, 0);
  EXPECT_TRUE(sameTree(*mapOf(cloud, given), *parseCloudMap(pcd, {0.1, given})));
}

}  // namespace
}  // namespace mrpt::fusion
