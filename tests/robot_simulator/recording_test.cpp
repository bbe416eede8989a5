// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "mission.h"
#include "robot_simulator.h"

namespace mrpt::fusion::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using mrpt::poses::CPose3D;

class Robots : public testing::Test {
 protected:
  Robots() {
    lidar.rings = 16;
    lidar.columns = 180;
    a.name = "a";
    a.waypoints = {{-2, 0}, {1, 0}};
    a.sensorPose = CPose3D(0.1, 0, 1, 0, 0.03, 0);
    a.T_w_map = CPose3D(-2.03, 0.11, 0.02, 0, 0, 0);
    b = a;
    b.name = "b";
    b.waypoints = {{2, 0.5}, {-1, 0.5}};
    b.T_w_map = CPose3D(1.97, 0.42, 0.05, 0.7, 0, 0);
    none.driftTranslation = none.driftRotation = 0;
    none.jitterTranslation = none.jitterRotation = 0;
  }

  /** A room of 8 x 6 x 2.5 m with a pillar. */
  static World room() {
    VoxelGrid grid(0.05, AlignedBox3d(Vector3d(-4.1, -3.1, -0.1), Vector3d(4.1, 3.1, 2.6)));
    grid.fill(AlignedBox3d(Vector3d(-4.1, -3.1, -0.1), Vector3d(4.1, 3.1, 2.6)));
    grid.clear(AlignedBox3d(Vector3d(-4, -3, 0), Vector3d(4, 3, 2.5)));
    grid.fill(AlignedBox3d(Vector3d(0.3, -2, 0), Vector3d(0.7, -1.6, 2.5)));
    return grid;
  }
  Recording drive(const RobotPlan& plan, const PoseNoise& noise, uint32_t seed) const {
    return simulateRobot(world, lidar, noise, plan, seed);
  }

  const World world = room();
  Lidar lidar;
  RobotPlan a, b;
  PoseNoise none;
};

double metresBetween(const CPose3D& p, const CPose3D& q) { return p.distanceTo(q); }
double radiansBetween(const CPose3D& p, const CPose3D& q) {
  return (q - p).getRotationMatrix().asEigen().eval().trace() >= 3
             ? 0
             : std::acos(((q - p).getRotationMatrix().asEigen().trace() - 1) / 2);
}

TEST_F(Robots, SameSeedSameScansOtherSeedOtherErrors) {
  const Recording once = drive(a, PoseNoise(), 7), again = drive(a, PoseNoise(), 7);
  const Recording other = drive(a, PoseNoise(), 8);
  ASSERT_EQ(once.scans.size(), again.scans.size());
  for (size_t i = 0; i < once.scans.size(); i++) {
    EXPECT_EQ(once.scans[i].points, again.scans[i].points);
    EXPECT_EQ(once.scans[i].estimatedPose.mean, again.scans[i].estimatedPose.mean);
    EXPECT_EQ(once.scans[i].truePose, other.scans[i].truePose);
    EXPECT_EQ(once.scans[i].hits, other.scans[i].hits);  // the same building
  }
  EXPECT_NE(once.scans.back().points, other.scans.back().points);
  EXPECT_NE(once.scans.back().estimatedPose.mean, other.scans.back().estimatedPose.mean);
}

TEST_F(Robots, WithoutPoseErrorsTheTruthIsTheRelationOfTheFrames) {
  const Recording ra = drive(a, none, 1), rb = drive(b, none, 2);
  const CPose3D truth = relativePoseTruth(ra, rb), frames = b.T_w_map - a.T_w_map;
  EXPECT_LT(metresBetween(truth, frames), 1e-6);
  EXPECT_LT(radiansBetween(truth, frames), 1e-6);
  const CPose3D world_in_a = CPose3D() - a.T_w_map;
  EXPECT_LT(metresBetween(worldPoseTruth(ra), world_in_a), 1e-6);
}

TEST_F(Robots, WithPoseErrorsTheTruthIsNearThatRelationButNotIt) {
  const Recording ra = drive(a, PoseNoise(), 1), rb = drive(b, PoseNoise(), 2);
  const CPose3D truth = relativePoseTruth(ra, rb), frames = b.T_w_map - a.T_w_map;
  EXPECT_LT(metresBetween(truth, frames), 0.1);
  EXPECT_GT(metresBetween(truth, frames), 1e-4);
}

TEST_F(Robots, ScansWithoutPoseErrorsPutAllPointsOnTheWorldsSurfacesInTheFirstFrame) {
  lidar.rangeSigma = 0;
  const std::vector<Recording> all =
      withoutPoseErrors({drive(a, PoseNoise(), 1), drive(b, PoseNoise(), 2)});
  ASSERT_EQ(all.size(), 2U);
  const CPose3D T_w_a = CPose3D() - worldPoseTruth(drive(a, PoseNoise(), 1));
  for (const Recording& recording : all)
    for (const Scan& scan : recording.scans) {
      EXPECT_EQ(scan.points.size(), scan.hits.size());
      for (size_t i = 0; i < scan.points.size(); i += 50) {
        const auto p = (T_w_a + scan.estimatedPose.mean + recording.sensorPose)
                           .composePoint(mrpt::math::TPoint3D(scan.points[i]));
        EXPECT_LT(p.distanceTo(mrpt::math::TPoint3D(scan.hits[i])), 1e-4);
      }
    }
}

TEST_F(Robots, RangesScatterAsTold) {
  lidar.rangeSigma = 0.03;
  double squares = 0, n = 0;
  const Recording r = drive(a, none, 3);
  for (const Scan& scan : r.scans)
    for (size_t i = 0; i < scan.points.size(); i++) {
      const auto sensor = scan.truePose + r.sensorPose;
      const double truth =
          mrpt::math::TPoint3D(scan.hits[i])
              .distanceTo(mrpt::math::TPoint3D(sensor.x(), sensor.y(), sensor.z()));
      const double error = scan.points[i].norm() - truth;
      squares += error * error;
      n++;
    }
  EXPECT_NEAR(std::sqrt(squares / n), 0.03, 0.001);
}

TEST_F(Robots, ABlockedWayIsReportedWithItsPlace) {
  a.waypoints = {{-2, 0}, {0.5, 0}, {0.5, -2.5}};
  try {
    checkPathIsFree(world, a);
    FAIL() << "drove through a pillar";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("from waypoint 2 to 3 is blocked at ("), std::string::npos)
        << e.what();
  }
  a.waypoints = {{0, 0}};
  EXPECT_THROW(checkPathIsFree(world, a), std::runtime_error);
}

/** What loadMission() says of geb079.ini with one line replaced. */
std::string complaintAbout(const std::string& key, const std::string& line) {
  std::ifstream good(std::string(MISSION_DIR) + "/geb079.ini");
  const std::string path = testing::TempDir() + "/bad_mission.ini";
  std::ofstream bad(path);
  for (std::string text; std::getline(good, text);)
    bad << (text.rfind(key + " =", 0) == 0 ? line : text) << "\n";
  bad.close();
  try {
    loadMission(path);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

TEST(MissionFiles, BadValuesAreNamedInOneLine) {
  for (const auto& [key, line] :
       std::vector<std::pair<std::string, std::string>>{{"rings", "rings = 0"},
                                                        {"rings", "rings = 2.5"},
                                                        {"columns", "columns = many"},
                                                        {"max_range", "max_range = -1"},
                                                        {"max_range", ""},
                                                        {"out_of_plane", "out_of_plane = 2"},
                                                        {"waypoints", "waypoints = 1 2; 3"},
                                                        {"speed", "speed = 0"},
                                                        {"sensor_pose", "sensor_pose = 1 2 3"}}) {
    const std::string complaint = complaintAbout(key, line);
    EXPECT_NE(complaint.find(key), std::string::npos) << "'" << line << "': " << complaint;
    EXPECT_EQ(complaint.find('\n'), std::string::npos) << complaint;
  }
  EXPECT_EQ(complaintAbout("no such key", ""), "");
  EXPECT_THROW(loadMission("/no/such/file.ini"), std::runtime_error);
}

}  // namespace
}  // namespace mrpt::fusion::sim
