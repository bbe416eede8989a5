// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the insertion and the likelihood of observations. */

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRange.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/obs/CRawlog.h>

#include "support/mrpt_tools.h"
#include "support/observations.h"

using namespace map_tests;
using namespace mrpt::obs;
using mrpt::maps::COctoMap;
using mrpt::maps::CProbOctoMap;
using mrpt::poses::CPose3D;

namespace {

const std::vector<CPose3D> kRobotPoses = {CPose3D(), CPose3D(1.23, -2.34, 0.57, 0.7, 0, 0),
                                          CPose3D(-3.1, 0.4, -1.2, -2.1, 0.3, -0.25)};

/** Options for both kinds of map. */
struct Options {
  std::string name, ini;
};
std::ostream& operator<<(std::ostream& o, const Options& options) { return o << options.name; }
std::string nameOf(const testing::TestParamInfo<Options>& options) { return options.param.name; }

const std::vector<Options> kOptions = {
    {"Defaults", "[o]\n"},
    {"Unusual",
     "[o]\nmaxrange = 2.6\npruning = false\noccupancyThres = 0.55\nprobHit = 0.83\n"
     "probMiss = 0.31\nclampingThresMin = 0.05\nclampingThresMax = 0.99\n"}};

/** Returns a scan of a real lidar. Null if the example files of MRPT are not installed. */
CObservationVelodyneScan::Ptr velodyneScan() {
  const std::string path = "/usr/share/mrpt/datasets/test_velodyne_VLP16.rawlog";
  CRawlog log;
  if (!std::filesystem::exists(path) || !log.loadFromRawLogFile(path)) return nullptr;
  for (size_t i = 0; i < log.size(); i++)
    if (auto scan = std::dynamic_pointer_cast<CObservationVelodyneScan>(log.getAsGeneric(i)))
      return scan;
  return nullptr;
}

/** Returns depthImage() with a hole. */
CObservation3DRangeScan::Ptr depthImageWithHole(const CPose3D& sensor) {
  auto obs = depthImage(sensor);
  for (int r = 9; r < 12; r++)
    for (int c = 0; c < 6; c++) obs->rangeImage(r, c) = 0;
  return obs;
}

/** Returns the points of the pixels of depthImageWithHole() in the sensor's frame, by the pinhole
 * model. */
std::vector<mrpt::math::TPoint3Df> pinholePoints(const CObservation3DRangeScan& obs) {
  std::vector<mrpt::math::TPoint3Df> points;
  for (int r = 0; r < obs.rangeImage.rows(); r++)
    for (int c = 0; c < obs.rangeImage.cols(); c++) {
      const float depth = 0.001F * static_cast<float>(obs.rangeImage(r, c));
      if (depth > 0)
        points.emplace_back(depth, depth * (15.5F - static_cast<float>(c)) / 30,
                            depth * (11.5F - static_cast<float>(r)) / 30);
    }
  return points;
}

}  // namespace

// ---------------------------------------------------------------- compared with COctoMap

class LikeCOctoMap : public testing::TestWithParam<Options> {
 protected:
  /** Inserts an observation from several poses in both kinds of map, and compares them. */
  void expectSameMaps(const CObservation& obs, double resolution) {
    const mrpt::config::CConfigFileMemory ini(GetParam().ini);
    CProbOctoMap ours(resolution);
    COctoMap theirs(resolution);
    ours.insertionOptions.loadFromConfigFile(ini, "o");
    theirs.insertionOptions.loadFromConfigFile(ini, "o");
    for (const auto& pose : kRobotPoses) {
      ASSERT_TRUE(theirs.insertObservation(obs, pose));
      ASSERT_TRUE(ours.insertObservation(obs, pose));
      const auto expected = occupanciesOf(theirs);
      ASSERT_GT(expected.size(), 400U);
      EXPECT_TRUE(sameVoxels(expected, occupanciesOf(ours)));
    }
    for (const uint32_t decimation : {1, 3}) {
      double sum = 0;
      ours.likelihoodOptions.decimation = theirs.likelihoodOptions.decimation = decimation;
      for (const auto& pose : kRobotPoses) {
        const CPose3D nearby = pose + CPose3D(0.02, 0.05, 0, 0.02, 0, 0);
        const double expected = theirs.computeObservationLikelihood(obs, nearby);
        EXPECT_NEAR(expected, ours.computeObservationLikelihood(obs, nearby),
                    1e-6 * std::abs(expected));
        sum += expected;
      }
      EXPECT_LT(sum, 0);
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Options, LikeCOctoMap, testing::ValuesIn(kOptions), nameOf);

TEST_P(LikeCOctoMap, Inserts2DScans) { expectSameMaps(*scan2d(), 0.1); }

TEST_P(LikeCOctoMap, Inserts2DScansFromASensorPose) { expectSameMaps(*scan2d(kSensorPose), 0.1); }

TEST_P(LikeCOctoMap, Inserts3DScans) {
  auto points = domePoints(1);
  points[10] = points[77] = {0, 0, 0};  // no echo
  expectSameMaps(*scan3dOf(points), 0.1);
}

TEST_P(LikeCOctoMap, InsertsPointClouds) { expectSameMaps(*cloudOf(domePoints(2)), 0.1); }

TEST_P(LikeCOctoMap, InsertsVelodyneScans) {
  const auto scan = velodyneScan();
  if (!scan) GTEST_SKIP() << "MRPT's example rawlogs are not installed";
  scan->sensorPose = CPose3D();
  scan->generatePointCloud();
  ASSERT_FALSE(scan->point_cloud.x.empty());
  expectSameMaps(*scan, 0.4);
}

TEST_P(LikeCOctoMap, InsertsPointsOfTheMapsFrame) {
  const mrpt::config::CConfigFileMemory ini(GetParam().ini);
  CProbOctoMap ours(0.1);
  ours.insertionOptions.loadFromConfigFile(ini, "o");
  CProbOctoMap by_observation = ours;
  const CPose3D sensor(0.31, -0.22, 0.13, 0, 0, 0);
  const auto cloud = cloudOf(domePoints(3), CPose3D());
  auto in_map = mrpt::maps::CSimplePointsMap();
  in_map.changeCoordinatesReference(*cloud->pointcloud, sensor);
  ours.insertPointCloud(in_map, 0.31F, -0.22F, 0.13F);
  by_observation.insertObservation(*cloud, sensor);
  EXPECT_TRUE(sameVoxels(occupanciesOf(by_observation), occupanciesOf(ours)));
}

TEST_P(LikeCOctoMap, UpdatesSingleVoxels) {
  const mrpt::config::CConfigFileMemory ini(GetParam().ini);
  CProbOctoMap ours(0.1);
  COctoMap theirs(0.1);
  ours.insertionOptions.loadFromConfigFile(ini, "o");
  theirs.insertionOptions.loadFromConfigFile(ini, "o");
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  for (int i = 0; i < 3000; i++) {
    const double x = place(rng), y = place(rng), z = place(rng);
    const bool occupied = rng() % 3 == 0;
    ours.updateVoxel(x, y, z, occupied);
    theirs.updateVoxel(x, y, z, occupied);
  }
  EXPECT_TRUE(sameVoxels(occupanciesOf(theirs), occupanciesOf(ours)));
}

TEST(ProbOctoMapObservations, CastsRaysAsCOctoMapDoes) {
  const auto cloud = cloudOf(domePoints(5, 2000));
  CProbOctoMap ours(0.2);
  COctoMap theirs(0.2);
  ours.insertObservation(*cloud);
  theirs.insertObservation(*cloud);
  size_t hits = 0;
  for (int i = 0; i < 200; i++) {
    const double a = 0.0314 * i;
    for (const bool ignore_unknown : {false, true}) {
      mrpt::math::TPoint3D end, expected_end;
      const mrpt::math::TPoint3D direction(std::cos(a), std::sin(a), 0.3 * std::sin(5 * a));
      const double max_range = i % 2 ? -1.0 : 2.5;
      const bool expected =
          theirs.castRay({0.1, 0.2, 0}, direction, expected_end, ignore_unknown, max_range);
      EXPECT_EQ(expected, ours.castRay({0.1, 0.2, 0}, direction, end, ignore_unknown, max_range));
      EXPECT_EQ(expected_end, end);
      hits += expected;
    }
  }
  EXPECT_GT(hits, 100U);
  EXPECT_LT(hits, 400U);
}

// ---------------------------------------------------------------- errors of COctoMap

class SensorPose : public testing::TestWithParam<bool> {
 protected:
  static CProbOctoMap mapOf(const CObservation& obs, const CPose3D& robot) {
    CProbOctoMap map(0.1);
    map.insertionOptions.maxrange = GetParam() ? 2.5 : -1;
    EXPECT_TRUE(map.insertObservation(obs, robot));
    return map;
  }
  /** Expects that the pose of the sensor on the robot has the same effect as the pose of the robot.
   */
  static void expectMoved(const CObservation& on_robot, const CObservation& at_origin) {
    for (const auto& robot : kRobotPoses) {
      const auto expected = mapOf(at_origin, robot + kSensorPose);
      const auto map = mapOf(on_robot, robot);
      EXPECT_TRUE(sameTree(expected.octree(), map.octree()));
      EXPECT_NEAR(expected.computeObservationLikelihood(at_origin, robot + kSensorPose),
                  map.computeObservationLikelihood(on_robot, robot), 1e-9);
    }
  }
};
INSTANTIATE_TEST_SUITE_P(MaxRange, SensorPose, testing::Bool());

TEST_P(SensorPose, MovesThePointsOf3DScans) {
  expectMoved(*scan3dOf(domePoints(6), kSensorPose), *cloudOf(domePoints(6)));
}

TEST_P(SensorPose, MovesPointClouds) {
  expectMoved(*cloudOf(domePoints(7), kSensorPose), *cloudOf(domePoints(7)));
}

TEST_P(SensorPose, MovesVelodyneScans) {
  const auto on_robot = velodyneScan();
  if (!on_robot) GTEST_SKIP() << "MRPT's example rawlogs are not installed";
  on_robot->generatePointCloud();
  const auto& c = on_robot->point_cloud;
  std::vector<mrpt::math::TPoint3Df> points;
  for (size_t i = 0; i < c.x.size(); i += 7) points.emplace_back(c.x[i], c.y[i], c.z[i]);
  auto& kept = on_robot->point_cloud;
  kept.clear();
  for (const auto& p : points) {
    kept.x.push_back(p.x);
    kept.y.push_back(p.y);
    kept.z.push_back(p.z);
  }
  on_robot->sensorPose = kSensorPose;
  expectMoved(*on_robot, *cloudOf(points));
}

TEST_P(SensorPose, MovesTheImageOfADepthCamera) {
  const auto image = depthImageWithHole(kSensorPose);
  expectMoved(*image, *depthImageWithHole(CPose3D()));
}

TEST(ProbOctoMapObservations, ADepthImageAloneIsProjectedByThePinholeModel) {
  const auto image = depthImageWithHole(kSensorPose);
  CProbOctoMap map(0.02);
  ASSERT_TRUE(map.insertObservation(*image, kRobotPoses[1]));
  EXPECT_FALSE(image->hasPoints3D);  // the observation is not changed
  CProbOctoMap expected(0.02);
  expected.insertObservation(*cloudOf(pinholePoints(*image), kSensorPose), kRobotPoses[1]);
  // The two projections round differently: a few points fall on other sides of a voxel's faces.
  const auto got = voxelsOf(map.octree()), want = voxelsOf(expected.octree());
  size_t same = 0;
  for (const auto& [k, v] : want) {
    const auto it = got.find(k);
    same += it != got.end() && it->second == v;
  }
  ASSERT_GT(want.size(), 10000U);
  EXPECT_GT(static_cast<double>(same), 0.99 * static_cast<double>(want.size()));
  EXPECT_NEAR(static_cast<double>(want.size()), static_cast<double>(got.size()),
              0.01 * static_cast<double>(want.size()));
}

TEST(ProbOctoMapObservations, AVelodyneScanOfRawPacketsAloneIsDecoded) {
  const auto raw = velodyneScan();
  if (!raw) GTEST_SKIP() << "MRPT's example rawlogs are not installed";
  raw->point_cloud.clear();
  CObservationVelodyneScan decoded(*raw);
  decoded.generatePointCloud();
  CProbOctoMap map(0.5), expected(0.5);
  ASSERT_TRUE(map.insertObservation(*raw));
  ASSERT_TRUE(expected.insertObservation(decoded));
  EXPECT_FALSE(map.isEmpty());
  EXPECT_TRUE(sameTree(expected.octree(), map.octree()));
  EXPECT_TRUE(raw->point_cloud.x.empty());
}

TEST(ProbOctoMapObservations, PointsThatAreNotFiniteAreLeftOut) {
  auto points = domePoints(8);
  CProbOctoMap expected(0.1), map(0.1);
  expected.insertObservation(*cloudOf(points));
  points.emplace_back(std::nanf(""), 1.0F, 1.0F);
  points.emplace_back(1.0F, std::numeric_limits<float>::infinity(), 1.0F);
  map.insertObservation(*cloudOf(points));
  EXPECT_TRUE(sameTree(expected.octree(), map.octree()));
}

// ---------------------------------------------------------------- observations without points

TEST(ProbOctoMapObservations, OtherKindsAreRefusedAndChangeNothing) {
  CProbOctoMap map(0.1);
  map.insertObservation(*scan2d());
  const auto before = nodesOf(map.octree());
  const CObservation3DRangeScan without_points;
  const CObservationPointCloud without_cloud;
  const CObservationOdometry odometry;
  CObservationRange sonar;  // of a cone, not of points: COctoMap does not take it either
  sonar.sensedData.resize(1);
  sonar.sensedData[0].sensedDistance = 1;
  EXPECT_FALSE(COctoMap(0.1).insertObservation(sonar));
  for (const CObservation* obs :
       {static_cast<const CObservation*>(&odometry), static_cast<const CObservation*>(&sonar),
        static_cast<const CObservation*>(&without_points),
        static_cast<const CObservation*>(&without_cloud)}) {
    EXPECT_FALSE(map.insertObservation(*obs)) << obs->GetRuntimeClass()->className;
    EXPECT_TRUE(sameNodes(before, nodesOf(map.octree())));
    EXPECT_EQ(0, map.computeObservationLikelihood(*obs, CPose3D()));
  }
  EXPECT_FALSE(map.canComputeObservationLikelihood(odometry));
  EXPECT_TRUE(map.canComputeObservationLikelihood(*scan2d()));
  EXPECT_TRUE(map.canComputeObservationLikelihood(*cloudOf(domePoints(1))));
}

TEST(ProbOctoMapObservations, InsertionCanBeSwitchedOff) {
  CProbOctoMap map(0.1);
  map.genericMapParams.enableObservationInsertion = false;
  EXPECT_FALSE(map.insertObservation(*scan2d()));
  EXPECT_TRUE(map.isEmpty());
}

TEST(ProbOctoMapObservations, LikelihoodCanBeSwitchedOffAsInCOctoMap) {
  CProbOctoMap ours(0.1);
  COctoMap theirs(0.1);
  const auto check = [&](auto& map) {
    map.insertObservation(*scan2d());
    EXPECT_TRUE(map.canComputeObservationLikelihood(*scan2d()));
    EXPECT_LT(map.computeObservationLikelihood(*scan2d(), CPose3D()), 0);
    map.genericMapParams.enableObservationLikelihood = false;
    EXPECT_FALSE(map.canComputeObservationLikelihood(*scan2d()));
    EXPECT_EQ(0, map.computeObservationLikelihood(*scan2d(), CPose3D()));
  };
  check(theirs);
  check(ours);
}

TEST(ProbOctoMapObservations, PointsOfNoSensorAreOneHitEach) {
  mrpt::maps::CSimplePointsMap points;
  for (const float x : {0.01F, 0.05F, 0.09F, 1.02F}) points.insertPoint(x, 0.03F, 0.04F);
  CProbOctoMap map(0.1), expected(0.1);
  map.insertionOptions.probHit = expected.insertionOptions.probHit = 0.6;
  map.insertPointCloud(points);
  for (int i = 0; i < 3; i++) expected.updateVoxel(0.05, 0.05, 0.05, true);
  expected.updateVoxel(1.05, 0.05, 0.05, true);
  EXPECT_TRUE(sameTree(expected.octree(), map.octree()));
  octomap::OcTree updated(map.octree());
  updated.updateInnerOccupancy();
  EXPECT_TRUE(sameTree(updated, map.octree()));
}

TEST(ProbOctoMapObservations, AMapIsEmptyUntilSomethingIsInsertedAndAfterClear) {
  CProbOctoMap map(0.1);
  EXPECT_TRUE(map.isEmpty());
  double p = 0.123;
  EXPECT_FALSE(map.getPointOccupancy(0, 0, 0, p));
  EXPECT_EQ(0.123, p);
  map.insertObservation(*scan2d());
  EXPECT_FALSE(map.isEmpty());
  map.clear();
  EXPECT_TRUE(map.isEmpty());
  EXPECT_EQ(0U, map.getNumLeafNodes());
  EXPECT_EQ(0.1, map.getResolution());
}

TEST(ProbOctoMapObservations, PointsOutsideTheGridHaveNoOccupancy) {
  CProbOctoMap map(0.1);
  map.updateVoxel(0, 0, 0, true);
  double p = 0.123;
  EXPECT_FALSE(map.getPointOccupancy(1e9F, 0, 0, p));
  EXPECT_FALSE(map.getPointOccupancy(-1e9F, 0, 0, p));
  EXPECT_EQ(0.123, p);
}

// ---------------------------------------------------------------- pruning and bad options

TEST(ProbOctoMapObservations, PruningIsWithoutLossAndCanBeSwitchedOff) {
  CProbOctoMap pruned(0.1), whole(0.1);
  whole.insertionOptions.pruning = false;
  for (int i = 0; i < 8; i++) {  // until the free space is at its lowest, equal everywhere
    pruned.insertObservation(*cloudOf(domePoints(9, 3000)));
    whole.insertObservation(*cloudOf(domePoints(9, 3000)));
  }
  EXPECT_LT(pruned.size(), whole.size());
  EXPECT_TRUE(sameVoxels(voxelsOf(whole.octree()), voxelsOf(pruned.octree())));
}

TEST(ProbOctoMapObservations, InnerNodesHoldTheirChildrensMaximumAfterAnInsertion) {
  CProbOctoMap map(0.1);
  map.insertObservation(*cloudOf(domePoints(10)));
  octomap::OcTree updated(map.octree());
  updated.updateInnerOccupancy();
  EXPECT_TRUE(sameTree(updated, map.octree()));
}

TEST(ProbOctoMapObservations, InsertionOptionsOutOfRangeThrowAndChangeNothing) {
  using Set = void (*)(CProbOctoMap::TInsertionOptions&);
  const std::vector<Set> bad = {[](auto& o) { o.occupancyThres = 0; },
                                [](auto& o) { o.occupancyThres = 1; },
                                [](auto& o) { o.probHit = 1; },
                                [](auto& o) { o.probHit = 0.4; },
                                [](auto& o) { o.probMiss = 0; },
                                [](auto& o) { o.probMiss = 0.6; },
                                [](auto& o) { o.probMiss = -0.1; },
                                [](auto& o) { o.probHit = std::nan(""); },
                                [](auto& o) { o.clampingThresMin = 0; },
                                [](auto& o) { o.clampingThresMax = 1; },
                                [](auto& o) { o.clampingThresMin = 0.98; },
                                [](auto& o) { o.clampingThresMax = std::nan(""); },
                                [](auto& o) { o.maxrange = 0; },
                                [](auto& o) { o.maxrange = std::nan(""); }};
  for (size_t i = 0; i < bad.size(); i++) {
    CProbOctoMap map(0.1);
    map.insertObservation(*scan2d());
    const auto before = nodesOf(map.octree());
    ASSERT_NO_THROW(map.insertionOptions.check());
    bad[i](map.insertionOptions);
    EXPECT_ANY_THROW(map.insertionOptions.check()) << i;
    EXPECT_ANY_THROW(map.insertObservation(*scan2d())) << i;
    EXPECT_ANY_THROW(map.updateVoxel(0, 0, 0, true)) << i;
    EXPECT_TRUE(sameNodes(before, nodesOf(map.octree()))) << i;
  }
}

TEST(ProbOctoMapObservations, AResolutionThatIsNoLengthThrows) {
  for (const double resolution : {0.0, -0.1, std::nan(""), HUGE_VAL})
    EXPECT_ANY_THROW(CProbOctoMap{resolution}) << resolution;
  EXPECT_ANY_THROW(CProbOctoMap{std::unique_ptr<octomap::OcTree>()});
}
