// SPDX-License-Identifier: BSD-3-Clause
#include "world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "buildings.h"
#include "mission.h"
#include "support/sanitizers.h"

namespace mrpt::fusion::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using map_tests::kHasSanitizer;

class Rays {
 public:
  double within(double limit) { return limit * (2 * share() - 1); }
  Vector3d direction() {
    Vector3d d;
    do d = Vector3d(within(1), within(1), within(1));
    while (d.norm() > 1 || d.norm() < 0.1);
    return d.normalized();
  }

 private:
  double share() { return static_cast<double>(random_()) / static_cast<double>(random_.max()); }
  std::mt19937 random_{1};
};

constexpr double kFine = 1e-3;  // m, of the brute-force twins

/** The first place along a ray where something is, found step by step. */
template <class IsInside>
double firstInside(const Vector3d& origin, const Vector3d& direction, double max_range,
                   IsInside&& inside) {
  for (double range = 0; range <= max_range; range += kFine)
    if (inside(origin + range * direction)) return range;
  return max_range + 1;
}

TEST(VoxelGridRays, EndWhereAWalkAlongThemFirstMeetsAVoxel) {
  Rays rays;
  VoxelGrid grid(0.1, AlignedBox3d(Vector3d(-1, -1, -1), Vector3d(1, 1, 1)));
  for (int i = 0; i < 60; i++) {
    const Vector3d at(rays.within(1), rays.within(1), rays.within(1));
    grid.fill(AlignedBox3d(at - Vector3d::Constant(0.08), at + Vector3d::Constant(0.08)));
  }
  int hits = 0;
  for (int i = 0; i < 600; i++) {
    const Vector3d origin(rays.within(1.5), rays.within(1.5), rays.within(1.5));
    const Vector3d direction = rays.direction();
    const auto range = grid.castRay(origin, direction, 3);
    const double walked =
        firstInside(origin, direction, 3, [&](const Vector3d& p) { return grid.isOccupied(p); });
    if (walked <= 3) {
      ASSERT_TRUE(range.has_value());
      EXPECT_LE(*range, walked + 1e-9);
      hits += 1;
      // The walk may step over a corner that the ray grazes; never over a millimetre more.
      if (*range < walked - 2 * kFine) {
        EXPECT_TRUE(grid.isOccupied(origin + (*range + 1e-7) * direction));
      }
    }
  }
  EXPECT_GT(hits, 50);
}

TEST(CapsuleRays, EndWhereAWalkAlongThemFirstGoesInside) {
  const Capsule person{{0.3, -0.2, 0.1}, 1.7, 0.25};
  const auto isInside = [&](const Vector3d& p) {
    const Vector3d low = person.foot + Vector3d(0, 0, person.radius);
    const Vector3d high = person.foot + Vector3d(0, 0, person.height - person.radius);
    Vector3d nearest = low;
    nearest.z() = std::clamp(p.z(), low.z(), high.z());
    return (p - nearest).norm() <= person.radius;
  };
  Rays rays;
  int hits = 0, hits_missed = 0;
  for (int i = 0; i < 300; i++) {
    const Vector3d origin(rays.within(1.5), rays.within(1.5), 1 + rays.within(1.5));
    const Vector3d aim =
        person.foot + Vector3d(rays.within(0.4), rays.within(0.4), 0.85 + rays.within(1));
    const Vector3d direction = (aim - origin).normalized();
    const auto range = castRay(person, origin, direction);
    const double walked = firstInside(origin, direction, 5, isInside);
    if (walked > 5) {
      hits_missed += range.has_value();  // grazed for less than a step of the walk
      continue;
    }
    ASSERT_TRUE(range.has_value());
    EXPECT_NEAR(*range, walked, 2 * kFine);
    hits++;
  }
  EXPECT_GT(hits, 100);
  EXPECT_LE(hits_missed, 2);
}

TEST(People, WalkToAndFroAtTheirSpeed) {
  Person person;
  person.way = {{0, 0}, {4, 0}, {4, 3}};  // 7 m
  person.speed = 0.5;
  person.headStart = 1;
  const auto at = [&](double time) { return Vector2d(person.at(time).foot.head<2>()); };
  EXPECT_TRUE(at(0).isApprox(Vector2d(1, 0)));
  EXPECT_TRUE(at(2).isApprox(Vector2d(2, 0)));
  EXPECT_TRUE(at(8).isApprox(Vector2d(4, 1)));           // 5 m along
  EXPECT_TRUE(at(14).isApprox(Vector2d(4, 2)));          // turned round at 7 m, 1 m back
  EXPECT_TRUE(at(2 + 2 * 14).isApprox(Vector2d(2, 0)));  // the same again after to and fro
}

/** A wall at x = 2, glass at x = 1, a person at x = 1.5 at time 0 who walks off along y. */
World glassAndPerson() {
  const AlignedBox3d extent(Vector3d(-1, -3, 0), Vector3d(3, 3, 2));
  World world{VoxelGrid(0.05, extent)};
  world.solid.fill(AlignedBox3d(Vector3d(2, -3, 0), Vector3d(2.1, 3, 2)));
  world.glass.emplace(0.05, extent);
  world.glass->fill(AlignedBox3d(Vector3d(1, -3, 0), Vector3d(1.05, 3, 2)));
  world.glassReturn = 0.3;
  Person person;
  person.way = {{1.6, 0}, {1.6, 2}};
  world.people = {person};
  return world;
}

TEST(Beams, MeetGlassOrWhatIsBehindIt) {
  const World world = glassAndPerson();
  const Vector3d origin(0, 0, 1), ahead = Vector3d::UnitX();
  const auto now = peopleAt(world, 0), later = peopleAt(world, 1);
  EXPECT_NEAR(*castRay(world, now, origin, ahead, 9, true), 1.0, 1e-9);
  EXPECT_NEAR(*castRay(world, now, origin, ahead, 9, false), 1.35, 1e-9);   // the person
  EXPECT_NEAR(*castRay(world, later, origin, ahead, 9, false), 2.0, 1e-9);  // has walked on
  EXPECT_FALSE(castRay(world, later, origin, ahead, 1.9, false).has_value());
}

TEST(Beams, GlassReturnsItsShare) {
  World world = glassAndPerson();
  world.people.clear();
  Lidar lidar;
  lidar.rings = 40;
  lidar.columns = 720;
  lidar.rangeSigma = 0;
  RobotPlan plan;
  plan.waypoints = {{0, -0.25}, {0, 0.25}};
  plan.sensorPose = mrpt::poses::CPose3D(0, 0, 1, 0, 0, 0);
  size_t from_glass = 0, from_wall = 0;
  for (const Scan& scan : simulateRobot(world, lidar, PoseNoise(), plan, 1).scans)
    for (const auto& hit : scan.hits) {
      // Of the beams that meet the wall if the glass lets them through.
      const double x = hit.x - scan.truePose.x(), y = hit.y - scan.truePose.y(), z = hit.z - 1;
      if (x < 0.9 || std::abs(y) > 0.4 * x || std::abs(z) > 0.4 * x) continue;
      (hit.x < 1.5 ? from_glass : from_wall)++;
    }
  const double n = static_cast<double>(from_glass + from_wall);
  EXPECT_GT(n, 1000);
  EXPECT_NEAR(static_cast<double>(from_glass) / n, world.glassReturn, 0.05);
}

TEST(Buildings, AreAlwaysTheSame) {
  std::vector<World (*)()> makers = {lobby};
  if (!kHasSanitizer) makers.push_back(office);  // the larger building takes a minute there
  for (const auto make : makers) {
    const octomap::OcTree once = make().solid.toOcTree(), again = make().solid.toOcTree();
    EXPECT_TRUE(once == again);
    EXPECT_GT(once.size(), 10000U);
  }
}

TEST(Buildings, AreAsLargeAsTheySay) {
  const auto sizeOf = [](const World& world) {
    double x = 0, y = 0, z = 0;
    world.solid.toOcTree().getMetricSize(x, y, z);
    return Vector3d(x, y, z);
  };
  EXPECT_TRUE(sizeOf(office()).isApprox(Vector3d(50, 40, 3.2), 0.01)) << sizeOf(office());
  EXPECT_NEAR(sizeOf(lobby()).x(), 40, 1);
}

TEST(Buildings, TheStoreyHasCorridorsThatCross) {
  if (kHasSanitizer) GTEST_SKIP() << "the building takes minutes with a sanitizer";
  const World world = storey();
  RobotPlan plan;
  plan.sensorPose = mrpt::poses::CPose3D(0, 0, 1, 0, 0, 0);
  plan.radius = plan.groundClearance = 0.2;
  for (const double x : {17.0, 34.5, 50.2, 69.0, 85.6, 104.1}) {
    plan.waypoints = {{x, 1}, {x, 93}};
    EXPECT_NO_THROW(checkPathIsFree(world, plan)) << x;
  }
  for (const double y : {6.65, 20.0, 34.1, 47.2, 61.05, 74.3, 87.6}) {
    plan.waypoints = {{1, y}, {120, y}};
    EXPECT_NO_THROW(checkPathIsFree(world, plan)) << y;
  }
  plan.waypoints = {{17, 6.65}, {34.5, 20}};
  EXPECT_THROW(checkPathIsFree(world, plan), std::runtime_error) << "across the rooms";
}

TEST(Buildings, HavePeopleWhoWalkThroughNothingSolid) {
  const World world = lobby();
  EXPECT_GE(world.people.size(), 5U);
  for (size_t i = 0; i < world.people.size(); i++)
    for (double time = 0; time < 120; time += 0.1) {
      const Capsule c = world.people[i].at(time);
      for (double z = c.radius; z < c.height; z += 0.2)  // above the floor that it stands on
        for (int angle = 0; angle < 8; angle++) {
          const Vector3d p = c.foot + Vector3d(c.radius * std::cos(angle * M_PI / 4),
                                               c.radius * std::sin(angle * M_PI / 4), z);
          ASSERT_FALSE(world.solid.isOccupied(p)) << "person " << i << " at " << p.transpose();
        }
    }
}

TEST(Missions, HaveFreeWays) {
  const auto check = [](const char* file, const World& world) {
    const Mission mission = loadMission(std::string(MISSION_DIR) + "/" + file);
    ASSERT_EQ(mission.robots.size(), 2U);
    for (const RobotPlan& plan : mission.robots) EXPECT_NO_THROW(checkPathIsFree(world, plan));
  };
  check("lobby.ini", lobby());
  check("office.ini", office());
}

}  // namespace
}  // namespace mrpt::fusion::sim
