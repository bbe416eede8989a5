// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of a team of simulated robots on a corridor. */
#include <gtest/gtest.h>
#include <mrpt/fusion/many_maps.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "robot_simulator.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::simulated_team_test {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/** A corridor of 19.5 x 1.8 m along x, with four rooms on both sides. Every third piece of
 * furniture is there at times 1 and 2 but not at time 0, every third not at time 1, every third not
 * at time 2. */
sim::World corridor(size_t time) {
  constexpr double kHeight = 2.6, kDoor = 2.05;
  const AlignedBox3d extent(Vector3d(-0.15, -0.15, -0.1), Vector3d(19.65, 12, kHeight + 0.1));
  sim::VoxelGrid solid(0.05, extent);
  solid.fill(extent);  // a block; the rooms are cut out
  const auto clear = [&](double x0, double y0, double x1, double y1, double height) {
    solid.clear({Vector3d(x0, y0, 0), Vector3d(x1, y1, height)});
  };
  clear(0, 4.85, 19.5, 6.65, kHeight);
  const std::pair<double, double> lower[] = {{0, 4.95}, {5.1, 9.45}, {9.6, 15}, {15.15, 19.5}},
                                  upper[] = {{0, 5.45}, {5.6, 10.55}, {10.7, 14.75}, {14.9, 19.5}};
  for (const auto& [begin, end] : lower) clear(begin, 0, end, 4.7, kHeight);
  for (const auto& [begin, end] : upper) clear(begin, 6.8, end, 11.8, kHeight);
  for (const double x : {2.2, 7.15, 10.55, 17.65}) clear(x, 4.7, x + 1, 4.85, kDoor);
  for (const double x : {1.1, 9.2, 11.6, 17.4}) clear(x, 6.65, x + 1, 6.8, kDoor);
  const double furniture[][5] = {// x0 y0 x1 y1 height
                                 {0.15, 0, 0.75, 0.45, 1.5},      {0, 1.8, 0.45, 2.95, 0.65},
                                 {6.1, 0, 6.9, 0.5, 1.05},        {14.5, 2.8, 15, 3.5, 1.3},
                                 {9.6, 2.75, 10.25, 3.2, 1.25},   {11.5, 0, 12, 1.4, 1},
                                 {9.6, 1.35, 10.2, 1.75, 0.9},    {18.9, 2.95, 19.5, 3.5, 2},
                                 {17.65, 0, 18.65, 0.5, 1.4},     {4.95, 9, 5.45, 9.75, 2.05},
                                 {5.8, 11, 6.7, 11.8, 1.65},      {5.6, 10.6, 7, 11.1, 1.85},
                                 {5.6, 9, 6.95, 9.8, 2},          {14.35, 7.35, 14.75, 7.85, 1.5},
                                 {14.05, 10.3, 14.75, 11.5, 2},   {10.7, 11.25, 11.15, 11.65, 1},
                                 {11.65, 11.5, 13, 11.8, 1.4},    {17.6, 10.6, 18.5, 11.8, 1.7},
                                 {19.1, 9.5, 19.5, 10.8, 1.15},   {12.65, 4.85, 13.55, 5.15, 1.05},
                                 {18.95, 4.85, 19.45, 5.15, 1.85}};
  for (size_t i = 0; i < std::size(furniture); i++) {
    const auto& f = furniture[i];
    if (i % 3 != time) solid.fill({Vector3d(f[0], f[1], 0), Vector3d(f[2], f[3], f[4])});
  }
  return solid;
}

/** The map of a recording, in the robot's own frame. */
PreparedMap mapOf(const sim::Recording& recording) {
  octomap::OcTree map(0.1);
  for (const sim::Scan& scan : recording.scans) {
    const mrpt::poses::CPose3D sensor = scan.estimatedPose.mean + recording.sensorPose;
    octomap::Pointcloud points;
    for (const auto& p : scan.points) {
      const mrpt::math::TPoint3D q = sensor.composePoint(mrpt::math::TPoint3D(p));
      points.push_back(float(q.x), float(q.y), float(q.z));
    }
    map.insertPointCloud(points,
                         octomap::point3d(float(sensor.x()), float(sensor.y()), float(sensor.z())));
  }
  return PreparedMap(map);
}

/** Robots on overlapping parts of the corridor. Each way is driven at each time once. */
std::vector<sim::Recording> drives(size_t robots, uint32_t seed) {
  sim::Lidar lidar;
  lidar.columns = 360;
  lidar.maxRange = 6;
  lidar.rangeSigma = 0.01;
  const std::vector<std::vector<Eigen::Vector2d>> ways = {
      {{5.5, 5.8}, {7.7, 5.8}, {7.7, 3.7}, {7.7, 5.8}, {12.1, 5.8}, {12.1, 7.8}},
      {{14, 5.8}, {9.7, 5.8}, {9.7, 7.8}, {9.7, 5.8}, {7.7, 5.8}, {7.7, 3.7}},
      {{4, 5.8}, {11, 5.8}, {11, 3.7}, {11, 5.8}, {12.1, 5.8}, {12.1, 7.8}}};
  std::vector<sim::Recording> recordings;
  for (size_t i = 0; i < robots; i++) {
    const std::vector<Eigen::Vector2d>& way = ways[i % 3];
    sim::RobotPlan plan;
    plan.name = std::string(1, static_cast<char>('a' + i));
    plan.waypoints = way;
    plan.sensorPose = mrpt::poses::CPose3D(0.1, 0, 1, 0, 2 * kDegree, 0);
    plan.T_w_map = mrpt::poses::CPose3D(way[0].x(), way[0].y(), 0.02, -0.2 * double(i), 0, 0);
    recordings.push_back(
        simulateRobot(corridor((i + i / 3) % 3), lidar, {}, plan, seed + static_cast<uint32_t>(i)));
  }
  return recordings;
}

/** Fuses the maps of some robots without a guess. All must join, at their right poses. */
void expectAllJoin(size_t robots) {
  const std::vector<sim::Recording> recordings = drives(robots, 11);
  std::vector<RobotMap> maps;
  for (const sim::Recording& recording : recordings)
    maps.push_back({std::string(1, static_cast<char>('a' + maps.size())), mapOf(recording)});
  const ManyFused fused = fuseMaps(maps, {});
  for (const TeamPair& pair : fused.pairs) {
    ASSERT_TRUE(pair.accepted) << pair.a << pair.b;
    ASSERT_GT(pair.probability, 0.95) << pair.a << pair.b;
    EXPECT_TRUE(pair.holds) << pair.a << pair.b;
  }
  for (size_t i = 0; i < maps.size(); i++) {
    const FusionMember& member = fused.members[i];
    ASSERT_TRUE(member.joined) << member.robot;
    const Eigen::Isometry3d truth = toEigen(relativePoseTruth(recordings[0], recordings[i]));
    EXPECT_LT(metresBetween(toEigen(member.pose.mean), truth), 0.1) << member.robot;
    EXPECT_LT(degreesBetween(toEigen(member.pose.mean), truth), 1) << member.robot;
  }
}

TEST(SimulatedTeam, SureMatchesAreNotGivenUpForMapsBesideEachOther) { expectAllJoin(3); }

TEST(SimulatedTeam, ManyMapsOfAPlaceWhereThingsMoveAreNotLaidApart) { expectAllJoin(9); }

}  // namespace
}  // namespace mrpt::fusion::test::simulated_team_test
