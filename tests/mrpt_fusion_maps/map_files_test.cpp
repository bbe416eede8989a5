// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of map files, recordings and damaged files. */

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/Clock.h>
#include <mrpt/fusion/map_files.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap3D.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DInterpolator.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>

#include "mrpt_fusion_maps/recordings/crafted.h"
#include "support/mrpt_tools.h"
#include "support/observations.h"

using namespace map_tests;
using namespace mrpt::fusion;
using namespace mrpt::maps;
using namespace mrpt::obs;
using mrpt::config::CConfigFileMemory;
using mrpt::poses::CPose3D;
using mrpt::serialization::CSerializable;

namespace {

mrpt::Clock::time_point at(double seconds) { return mrpt::Clock::fromDouble(1.6e9 + seconds); }

CObservation::Ptr robotPose(double seconds, const CPose3D& pose) {
  auto obs = CObservationRobotPose::Create();
  obs->pose.mean = pose;
  return stamped(obs, seconds);
}

CObservation::Ptr odometry(double seconds, const mrpt::poses::CPose2D& pose) {
  auto obs = CObservationOdometry::Create();
  obs->odometry = pose;
  return stamped(obs, seconds);
}

CObservation::Ptr cloud(double seconds, unsigned seed, size_t points = 100) {
  return stamped(cloudOf(domePoints(seed, points), CPose3D(0.1, 0, 0.4, 0.2, 0, 0)), seconds);
}

CSerializable::Ptr frameOf(const CObservation::Ptr& obs) {
  auto frame = CSensoryFrame::Create();
  frame->insert(obs);
  return frame;
}

CSerializable::Ptr movement3D(const CPose3D& increment) {
  CActionRobotMovement3D action;
  action.poseChange.mean = increment;
  auto actions = CActionCollection::Create();
  actions->insert(action);
  return actions;
}

CSerializable::Ptr movement2D(const mrpt::poses::CPose2D& increment) {
  CActionRobotMovement2D action;
  CActionRobotMovement2D::TMotionModelOptions options;
  options.modelSelection = CActionRobotMovement2D::mmGaussian;
  action.computeFromOdometry(increment, options);
  auto actions = CActionCollection::Create();
  actions->insert(action);
  return actions;
}

void writeGz(const std::string& path, const std::string& bytes) {
  mrpt::io::CFileGZOutputStream out(path);
  out.Write(bytes.data(), bytes.size());
}

/** Returns a map of point clouds, each inserted at a pose. */
CProbOctoMap expectedMap(const std::vector<std::pair<CObservation::Ptr, CPose3D>>& inserted) {
  CProbOctoMap map;
  for (const auto& [obs, pose] : inserted) EXPECT_TRUE(map.insertObservation(*obs, pose));
  return map;
}

const char* const kLoaded = "loaded";
const char* const kCrash = "crash";

const CPose3D kPose0(0.3, -0.2, 0.1, 0.2, 0.05, -0.1), kPose2(2.3, 0.8, 0.5, 0.8, 0.05, -0.1);

/** Returns a recording in the observations format. The second cloud is half-way between two poses.
 */
Objects recording() {
  return {robotPose(0, kPose0), cloud(0, 1), cloud(1, 2), robotPose(2, kPose2)};
}

/** Returns a recording of few bytes, for tests that run once per byte. */
Objects shortRecording() {
  return {odometry(0, {0.3, -0.2, 0.1}), odometry(2, {1.3, 0.8, 0.5}), cloud(0.5, 1, 2),
          cloud(1, 2, 2)};
}

CPose3D halfWay(const CPose3D& a, const CPose3D& b) {
  mrpt::poses::CPose3DInterpolator path;
  path.setInterpolationMethod(mrpt::poses::imLinearSlerp);
  path.insert(at(0), a);
  path.insert(at(2), b);
  CPose3D half;
  bool valid = false;
  path.interpolate(at(1), half, valid);
  EXPECT_TRUE(valid);
  EXPECT_NEAR(0.5 * (a.x() + b.x()), half.x(), 1e-9);
  return half;
}

CProbOctoMap recordedMap() {
  return expectedMap({{cloud(0, 1), kPose0}, {cloud(1, 2), halfWay(kPose0, kPose2)}});
}

CSimpleMap simpleMap(unsigned count = 3, size_t points = 100) {
  CSimpleMap frames;
  for (unsigned i = 0; i < count; i++) {
    mrpt::poses::CPose3DPDFGaussian pose;
    pose.mean = CPose3D(0.7 * i, -0.3 * i, 0.1 * i, 0.2 * i, 0.1, 0);
    CSensoryFrame frame;
    frame.insert(cloud(i, 10 + i, points));
    frames.insert(pose, frame);
  }
  return frames;
}

/** Returns the bytes that MRPT writes for a null pointer. */
std::string nullObject() {
  mrpt::io::CMemoryStream memory;
  mrpt::serialization::archiveFrom(memory).WriteObject(nullptr);
  return {static_cast<const char*>(memory.getRawBufferData()),
          static_cast<size_t>(memory.getTotalBytesCount())};
}

CProbOctoMap simpleMapsMap() {
  std::vector<std::pair<CObservation::Ptr, CPose3D>> inserted;
  for (unsigned i = 0; i < 3; i++)
    inserted.emplace_back(cloud(i, 10 + i), CPose3D(0.7 * i, -0.3 * i, 0.1 * i, 0.2 * i, 0.1, 0));
  return expectedMap(inserted);
}

CMultiMetricMap several(const std::vector<CMetricMap::Ptr>& maps) {
  CMultiMetricMap set;
  for (const auto& m : maps) set.maps.push_back(m);
  return set;
}

/** Checks that an error is "<path>: <reason>" on one line. */
testing::AssertionResult saysWhatIsWrong(const std::string& error, const std::string& path) {
  if (error.empty()) return testing::AssertionFailure() << path << ": no error";
  const std::string start = path + ": ";
  if (error.compare(0, start.size(), start) != 0 || error.size() <= start.size() ||
      error.find('\n') != std::string::npos)
    return testing::AssertionFailure() << "'" << error << "'";
  return testing::AssertionSuccess();
}

class MapFiles : public testing::Test {
 protected:
  TempDir dir;

  std::string file(const std::string& name, const std::string& bytes) {
    writeRaw(dir.path(name), bytes);
    return dir.path(name);
  }
  std::string gzFile(const std::string& name, const std::string& bytes) {
    writeGz(dir.path(name), bytes);
    return dir.path(name);
  }
  /** Expects that a file gives this map, plain and compressed, for any name. */
  void expectLoads(const CProbOctoMap& expected, const std::string& bytes) {
    for (const std::string& path :
         {file("plain.ext", bytes), gzFile("packed.gz", bytes), file("lies.ot", bytes),
          file("lies.gz", bytes), gzFile("lies.bt", bytes)}) {
      std::shared_ptr<const CProbOctoMap> map;
      ASSERT_NO_THROW(map = loadMap(path)) << path;
      EXPECT_TRUE(sameTree(expected.octree(), map->octree())) << path;
    }
  }
  /** Loads many files. Returns kLoaded, kCrash or the error for each. The files are loaded in other
   * processes with little memory, because MRPT believes every length in a damaged file. */
  template <class BytesOf>
  std::vector<std::string> resultsOf(size_t count, const BytesOf& bytes_of,
                                     const CProbOctoMap* expected = nullptr) {
    std::vector<std::string> results;
    while (results.size() < count) {
      const std::string log = dir.path("results");
      const pid_t child = ::fork();
      if (child == 0) {
        const MemoryLimit limit(200);
        std::ofstream out(log);
        if (!std::freopen("/dev/null", "w", stderr)) ::_exit(1);  // OctoMap comments on each file
        for (size_t i = results.size(); i < count; i++) {
          const std::string path = file("cut", bytes_of(i));
          std::shared_ptr<const CProbOctoMap> map;
          std::string result = errorOf([&] { map = loadMap(path); });
          std::replace(result.begin(), result.end(), '\n', '|');
          if (map)
            result =
                expected && !sameTree(expected->octree(), map->octree()) ? "other map" : kLoaded;
          out << result << std::endl;
        }
        ::_exit(0);
      }
      int status = 0;
      ::waitpid(child, &status, 0);
      std::ifstream in(log);
      for (std::string line; std::getline(in, line);) results.push_back(line);
      if (status != 0) results.emplace_back(kCrash);
    }
    return results;
  }
  /** Loads the first 0, 1, 2, ... bytes. \param[in] expected If set, any other map is an error. */
  std::vector<std::string> resultsOfTruncations(const std::string& bytes,
                                                const CProbOctoMap* expected = nullptr) {
    return resultsOf(
        bytes.size(), [&](size_t n) { return bytes.substr(0, n); }, expected);
  }
  void expectRefused(const std::string& path) {
    EXPECT_TRUE(saysWhatIsWrong(errorOf([&] { loadMap(path); }), path));
    EXPECT_TRUE(saysWhatIsWrong(errorOf([&] { buildMap(path); }), path));
    EXPECT_THROW(loadMap(path), std::runtime_error);
    EXPECT_THROW(buildMap(path), std::runtime_error);
  }
};

}  // namespace

// ---------------------------------------------------------------- maps

TEST_F(MapFiles, LoadsOctreesByContent) {
  const auto tree = sceneTree(0.1, 1);
  for (const char* name : {"a.ot", "a.bt", "a.rawlog", "a.simplemap.gz", "a"}) {
    EXPECT_TRUE(sameTree(*tree, loadMap(file(name, toOtFile(*tree)))->octree())) << name;
    const std::string bt = toBtFile(*tree);
    EXPECT_TRUE(sameTree(*parseOcTreeFile(bt), loadMap(file(name, bt))->octree())) << name;
  }
}

TEST_F(MapFiles, LoadsSerializedProbOctoMaps) {
  CProbOctoMap map(sceneTree(0.1, 2));
  map.insertionOptions.maxrange = 6.5;
  map.octree().setProbHit(0.81);
  expectLoads(map, serialized(map));
  const auto loaded = loadMap(file("map", serialized(map)));
  EXPECT_EQ(6.5, loaded->insertionOptions.maxrange);
  EXPECT_EQ(sensorModelBits(map.octree()), sensorModelBits(loaded->octree()));
}

TEST_F(MapFiles, LoadsSerializedCOctoMaps) {
  COctoMap theirs(0.1);
  theirs.insertObservation(*cloud(0, 3));
  const std::string bytes = serialized(theirs);
  // The file of MRPT has one bit per voxel. The expected map is the map that MRPT reads.
  const auto read = std::dynamic_pointer_cast<COctoMap>(deserialized(bytes));
  ASSERT_TRUE(read);
  ASSERT_GT(read->size(), 100U);
  expectLoads(CProbOctoMap(*read), bytes);
}

TEST_F(MapFiles, LoadsTheFirstOctomapOfASet) {
  const auto points = CSimplePointsMap::Create();
  const auto first = std::make_shared<CProbOctoMap>(sceneTree(0.1, 3));
  const auto second = std::make_shared<CProbOctoMap>(smallTree());
  expectLoads(*first, serialized(several({points, first, second})));
  expectLoads(*second, serialized(several({second, points, first})));
  const auto nested = std::make_shared<CMultiMetricMap>(several({points, second}));
  expectLoads(*second, serialized(several({nested})));
}

TEST(AsProbOctoMap, IsTheMapItselfOrItsConversion) {
  const auto ours = std::make_shared<CProbOctoMap>(smallTree());
  EXPECT_EQ(ours.get(), asProbOctoMap(*ours).get());
  EXPECT_EQ(ours.get(), asProbOctoMap(several({CSimplePointsMap::Create(), ours})).get());
  const auto theirs = std::make_shared<COctoMap>(0.1);
  ours->toOctoMap(*theirs);
  for (const auto& map : {asProbOctoMap(*theirs), asProbOctoMap(several({theirs}))}) {
    ASSERT_TRUE(map);
    EXPECT_TRUE(sameTree(ours->octree(), map->octree()));
  }
  EXPECT_EQ(nullptr, asProbOctoMap(CSimplePointsMap()));
  EXPECT_EQ(nullptr, asProbOctoMap(CMultiMetricMap()));
}

TEST(AsProbOctoMap, TakesColouredOctomapsAndGridsOfCells) {
  const auto ours = std::make_shared<CProbOctoMap>(smallTree());
  const auto coloured = ours->toColouredOctoMap();
  for (const auto& map : {asProbOctoMap(*coloured), asProbOctoMap(several({coloured}))}) {
    ASSERT_TRUE(map);
    EXPECT_TRUE(sameTree(ours->octree(), map->octree()));
  }
  const auto grid = std::make_shared<COccupancyGridMap3D>();
  ours->toOccupancyGrid(*grid);
  const CProbOctoMap quantised(*grid);
  EXPECT_FALSE(quantised.isEmpty());
  for (const auto& map : {asProbOctoMap(*grid), asProbOctoMap(several({grid}))}) {
    ASSERT_TRUE(map);
    EXPECT_TRUE(sameTree(quantised.octree(), map->octree()));
  }
  // The map that has lost nothing is taken, in any order.
  EXPECT_EQ(ours.get(), asProbOctoMap(several({grid, coloured, ours})).get());
  EXPECT_TRUE(sameTree(ours->octree(), asProbOctoMap(several({grid, coloured}))->octree()));
}

TEST_F(MapFiles, LoadsSerializedGridsOfCells) {
  const CProbOctoMap ours(sceneTree(0.1, 5));
  COccupancyGridMap3D grid;
  ours.toOccupancyGrid(grid);
  expectLoads(CProbOctoMap(grid), serialized(grid));
}

// ---------------------------------------------------------------- recordings

TEST_F(MapFiles, InterpolatesTheRobotPosesOfARawlogOfObservations) {
  expectLoads(recordedMap(), bytesOf(recording()));
}

TEST_F(MapFiles, UsesRobotPosesThatComeLaterInTheFile) {
  Objects objects = recording();
  std::rotate(objects.begin(), objects.begin() + 1, objects.end());
  expectLoads(recordedMap(), bytesOf(objects));
}

TEST_F(MapFiles, InterpolatesOdometryIfThereAreNoRobotPoses) {
  const mrpt::poses::CPose2D start(0.3, -0.2, 0.1), end(1.3, 0.8, 0.5);
  const Objects objects = {odometry(0, start), cloud(1, 4), odometry(2, end)};
  expectLoads(expectedMap({{cloud(1, 4), halfWay(CPose3D(start), CPose3D(end))}}),
              bytesOf(objects));
}

TEST_F(MapFiles, RobotPosesGoBeforeOdometry) {
  Objects objects = recording();
  objects.push_back(odometry(0, {9, 9, 1}));
  objects.push_back(odometry(2, {19, 9, 1}));
  expectLoads(recordedMap(), bytesOf(objects));
}

TEST_F(MapFiles, AddsUpTheMovementsOfARawlogOfActions) {
  const CPose3D first(0.5, 0.1, 0.2, 0.3, -0.1, 0.05), second(1, -0.2, 0, -0.4, 0, 0);
  const mrpt::poses::CPose2D third(0.4, 0.1, 0.25);
  const Objects objects = {movement3D(first),    frameOf(cloud(0, 5)), movement3D(second),
                           frameOf(cloud(1, 6)), movement2D(third),    frameOf(cloud(2, 7))};
  expectLoads(expectedMap({{cloud(0, 5), first},
                           {cloud(1, 6), first + second},
                           {cloud(2, 7), first + second + CPose3D(third)}}),
              bytesOf(objects));
}

TEST_F(MapFiles, InsertsTheFramesOfASimplemapAtTheirPoses) {
  expectLoads(simpleMapsMap(), serialized(simpleMap()));
}

TEST_F(MapFiles, BuildsARealSimplemapAsMrptDoes) {
  const std::string path = "/usr/share/mrpt/datasets/localization_demo.simplemap.gz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not installed";
  CSimpleMap frames;
  ASSERT_TRUE(frames.loadFromFile(path));
  CProbOctoMap expected;
  expected.loadFromSimpleMap(frames);
  ASSERT_GT(expected.size(), 1000U);
  EXPECT_TRUE(sameTree(expected.octree(), loadMap(path)->octree()));
}

TEST_F(MapFiles, LoadsObservationsStoredBesideTheRawlog) {
  Objects objects = recording();
  std::filesystem::create_directory(dir.path("robot_Images"));
  const auto outside = cloudOf(domePoints(8), CPose3D());
  stamped(outside, 2);
  {
    mrpt::io::CFileGZOutputStream out(dir.path("robot_Images/cloud.bin"));
    mrpt::serialization::archiveFrom(out) << *outside->pointcloud;
  }
  const auto lazy = CObservationPointCloud::Create();
  lazy->timestamp = at(2);
  lazy->setAsExternalStorage("cloud.bin",
                             CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
  objects.push_back(lazy);
  CProbOctoMap expected = recordedMap();
  expected.insertObservation(*outside, kPose2);
  const auto map = loadMap(file("robot.rawlog", bytesOf(objects)));
  EXPECT_TRUE(sameTree(expected.octree(), map->octree()));
}

// ---------------------------------------------------------------- building

TEST_F(MapFiles, CountsWhatWasInsertedAndWhatWasNot) {
  Objects objects = recording();
  objects.push_back(stamped(CObservation2DRangeScan::Create(), -1));  // before the first pose
  objects.push_back(cloud(3, 9));                                     // after the last
  const auto without_points = CObservation3DRangeScan::Create();
  objects.push_back(stamped(without_points, 1));
  std::vector<size_t> progress;
  BuildParams params;
  params.progress = [&](size_t n) { progress.push_back(n); };
  const auto built = buildMap(file("a.rawlog", bytesOf(objects)), params);
  EXPECT_EQ(2U, built.inserted);
  EXPECT_EQ(3U, built.ignored);
  ASSERT_FALSE(progress.empty());
  EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end()));
  EXPECT_EQ(2U, progress.back());
  const auto map = std::dynamic_pointer_cast<CProbOctoMap>(built.map);
  ASSERT_TRUE(map);
  EXPECT_TRUE(sameTree(recordedMap().octree(), map->octree()));
}

TEST_F(MapFiles, BuildsTheMapsThatADefinitionAsksFor) {
  const std::string path = file("a.rawlog", bytesOf(recording()));
  const CConfigFileMemory ini(
      std::string("[Robot]\nprobOctoMap_count = 1\npointsMap_count = 1\n"
                  "[Robot_probOctoMap_00_creationOpts]\nresolution = 0.3\n"
                  "[Robot_probOctoMap_00_insertOpts]\nprobHit = 0.9\n"));
  BuildParams params;
  params.config = &ini;
  params.section = "Robot";
  CProbOctoMap expected(0.3);
  expected.insertionOptions.probHit = 0.9;
  expected.insertObservation(*cloud(0, 1), kPose0);
  expected.insertObservation(*cloud(1, 2), halfWay(kPose0, kPose2));

  const auto built = buildMap(path, params);
  const auto set = std::dynamic_pointer_cast<CMultiMetricMap>(built.map);
  ASSERT_TRUE(set);
  EXPECT_EQ(2U, set->maps.size());
  EXPECT_FALSE(set->mapByClass<CSimplePointsMap>()->empty());
  EXPECT_TRUE(sameTree(expected.octree(), set->mapByClass<CProbOctoMap>()->octree()));
  EXPECT_TRUE(sameTree(expected.octree(), loadMap(path, params)->octree()));
}

TEST_F(MapFiles, ADefinitionWithoutAMapOrWithoutAnOctomapIsAnError) {
  const std::string path = file("a.rawlog", bytesOf(recording()));
  BuildParams params;
  const CConfigFileMemory nothing(std::string("[MappingApplication]\nprobOctoMaps_count = 1\n"));
  params.config = &nothing;
  EXPECT_TRUE(saysWhatIsWrong(errorOf([&] { buildMap(path, params); }), path));
  EXPECT_TRUE(saysWhatIsWrong(errorOf([&] { loadMap(path, params); }), path));
  const CConfigFileMemory points(std::string("[MappingApplication]\npointsMap_count = 1\n"));
  params.config = &points;
  EXPECT_NO_THROW(buildMap(path, params));
  EXPECT_TRUE(saysWhatIsWrong(errorOf([&] { loadMap(path, params); }), path));
}

TEST_F(MapFiles, AMapClassThatIsMisspeltIsNamed) {
  const std::string path = file("a.rawlog", bytesOf(recording()));
  BuildParams params;
  params.section = "Robot";
  for (const std::string name : {"probOctmap", "octomaps", "mrpt::maps::COctomapp", ""}) {
    const CConfigFileMemory ini("[Robot]\nprobOctoMap_count = 1\n" + name + "_count = 1\n");
    params.config = &ini;
    const std::string error = errorOf([&] { buildMap(path, params); });
    EXPECT_TRUE(saysWhatIsWrong(error, path));
    const std::string expected =
        "the section [Robot] asks for '" + name + "', which is not a map class";
    EXPECT_NE(std::string::npos, error.find(expected)) << error;
  }
  for (const std::string name :
       {"pointsMap", "POINTSMAP", "CSimplePointsMap", "mrpt::maps::CSimplePointsMap"}) {
    const CConfigFileMemory ini("[Robot]\nprobOctoMap_count = 1\n" + name +
                                "_count = 0\ncounter = 2\n");
    params.config = &ini;
    EXPECT_NO_THROW(buildMap(path, params)) << name;
  }
}

TEST_F(MapFiles, OnlyRecordingsAreBuilt) {
  for (const std::string& bytes : {toOtFile(*smallTree()), serialized(CProbOctoMap(smallTree()))}) {
    const std::string path = file("map", bytes);
    EXPECT_NO_THROW(loadMap(path));
    EXPECT_TRUE(saysWhatIsWrong(errorOf([&] { buildMap(path); }), path));
  }
}

// ---------------------------------------------------------------- files that are rejected

TEST_F(MapFiles, FilesOfOtherKindsAreRefusedOnOneLine) {
  expectRefused(dir.path("missing.ot"));
  expectRefused(dir.path(""));
  expectRefused(file("empty.ot", ""));
  expectRefused(file("text.ot", "Dear reader,\nthis is not a map.\n"));
  expectRefused(file("short", "x"));
  expectRefused(file("zeros", std::string(1000, '\0')));
  expectRefused(gzFile("text.gz", "Dear reader,\nthis is not a map.\n"));
  expectRefused(gzFile("empty.gz", ""));
  expectRefused(file("pose.rawlog", serialized(CPose3D(1, 2, 3, 0, 0, 0))));
  expectRefused(file("bad.ot", "# Octomap OcTree file\nid OcTree\nsize 3\nres 0.1\ndata\nxyz"));
}

TEST_F(MapFiles, TheReasonOfMrptsExceptionsIsTheirMessageNotTheirTitle) {
  std::string unknown_class = serialized(CPose3D());
  unknown_class.replace(unknown_class.find("CPose3D"), 7, "CPose9D");
  const std::string path = file("unknown_class", unknown_class);
  expectRefused(path);
  EXPECT_NE(std::string::npos, errorOf([&] { loadMap(path); }).find("CPose9D"));
  // MRPT nests exceptions. The message is that of the first exception.
  std::string newer = serialized(CProbOctoMap(smallTree()));
  newer[newer.find("CProbOctoMap") + 12] = 2;
  const std::string newer_path = file("newer", newer);
  expectRefused(newer_path);
  EXPECT_NE(std::string::npos, errorOf([&] {
                                 loadMap(newer_path);
                               }).find("unknown serialization version number: '2'"));
  const std::string text = file("text", "Dear reader,\nthis is not a map.\n");
  for (const std::string& p : {path, newer_path, text}) {
    const std::string error = errorOf([&] { loadMap(p); });
    EXPECT_EQ(std::string::npos, error.find("==== MRPT exception")) << error;
  }
}

TEST_F(MapFiles, MapsWithoutOccupancyAreNamedInTheError) {
  const std::string points = file("points", serialized(CSimplePointsMap()));
  expectRefused(points);
  EXPECT_NE(std::string::npos, errorOf([&] { loadMap(points); }).find("CSimplePointsMap"));
  expectRefused(file("set", serialized(several({CSimplePointsMap::Create()}))));
  expectRefused(file("no_maps", serialized(CMultiMetricMap())));
}

TEST_F(MapFiles, RecordingsWithoutPosesOrObservationsAreRefused) {
  expectRefused(file("no_poses", bytesOf({cloud(0, 1), cloud(1, 2)})));
  expectRefused(file("no_observations", bytesOf({robotPose(0, kPose0), robotPose(2, kPose2)})));
  expectRefused(file("no_movements", bytesOf({frameOf(cloud(0, 1))})));
  expectRefused(file("no_frames", bytesOf({movement3D(kPose0)})));
  expectRefused(file("all_too_late", bytesOf({robotPose(0, kPose0), cloud(1, 1)})));
  expectRefused(file("no_keyframes", serialized(CSimpleMap())));
}

TEST_F(MapFiles, ANullObjectIsNoMap) {
  const std::string path = file("null", nullObject());
  // In another process, because a null pointer would end it.
  EXPECT_EXIT(
      ::_exit(errorOf([&] { loadMap(path); }).empty() || errorOf([&] { buildMap(path); }).empty()),
      testing::ExitedWithCode(0), "");
}

TEST_F(MapFiles, ANullObjectInARecordingIsAnError) {
  const CSimpleMap frames = simpleMap(1, 2);
  const auto& frame = *frames.begin();
  const std::string observation = serialized(**frame.sf->begin());
  const auto withNullFor = [&](std::string bytes, const std::string& object) {
    const size_t at = bytes.find(object);
    EXPECT_NE(std::string::npos, at);
    return at == std::string::npos ? bytes : bytes.replace(at, object.size(), nullObject());
  };
  for (const std::string& bytes : {withNullFor(serialized(frames), serialized(*frame.pose)),
                                   withNullFor(serialized(frames), serialized(*frame.sf)),
                                   withNullFor(serialized(frames), observation),
                                   serialized(mrpt::obs::CActionCollection()) +
                                       withNullFor(serialized(*frame.sf), observation)}) {
    const std::string path = file("null", bytes);
    EXPECT_EXIT(::_exit(!saysWhatIsWrong(errorOf([&] { buildMap(path); }), path)),
                testing::ExitedWithCode(0), "");
  }
}

TEST_F(MapFiles, EveryTruncationOfARawlogInsideAnObjectIsAnError) {
  const Objects objects = shortRecording();
  std::set<size_t> object_ends;
  size_t end = 0;
  for (const auto& o : objects) object_ends.insert(end += serialized(*o).size());
  const auto results = resultsOfTruncations(bytesOf(objects));
  std::vector<size_t> crashed, silent;
  for (size_t n = 1; n < results.size(); n++) {
    if (object_ends.count(n)) continue;  // a shorter, but whole, rawlog
    if (results[n] == kCrash)
      crashed.push_back(n);
    else if (results[n] == kLoaded)
      silent.push_back(n);
    else
      EXPECT_TRUE(saysWhatIsWrong(results[n], dir.path("cut"))) << n;
  }
  EXPECT_EQ(std::vector<size_t>(), crashed);
  EXPECT_EQ(std::vector<size_t>(), silent) << "bytes of " << results.size() << " taken for all";
}

TEST_F(MapFiles, EveryTruncationOfASimplemapOrMapIsAnError) {
  const auto ours = std::make_shared<CProbOctoMap>(smallTree());
  COctoMap theirs(0.1);
  ours->toOctoMap(theirs);
  for (const std::string& bytes :
       {serialized(simpleMap(1, 2)), serialized(*ours), serialized(theirs), toOtFile(*smallTree()),
        serialized(several({ours}))}) {
    const auto results = resultsOfTruncations(bytes);
    for (size_t n = 0; n < results.size(); n++)
      EXPECT_TRUE(saysWhatIsWrong(results[n], dir.path("cut"))) << n << " of " << bytes.size();
  }
}

TEST_F(MapFiles, ATruncatedGzFileNeverGivesAnotherMap) {
  for (const std::string& bytes : {bytesOf(shortRecording()), serialized(simpleMap(1, 2)),
                                   serialized(CProbOctoMap(smallTree()))}) {
    const std::string whole = readRaw(gzFile("whole.gz", bytes));
    const auto results = resultsOfTruncations(whole, loadMap(dir.path("whole.gz")).get());
    size_t loaded = 0;
    for (size_t n = 0; n < results.size(); n++)
      if (results[n] == kLoaded)  // the map as it is: only the checksum at the end is missing
        loaded++;
      else
        EXPECT_TRUE(saysWhatIsWrong(results[n], dir.path("cut"))) << n << " of " << whole.size();
    EXPECT_LT(loaded, 20U);
  }
}

TEST_F(MapFiles, FlippedBitsInAMapNeverCrash) {
  const CProbOctoMap map(smallTree());
  const std::string plain = serialized(map);
  const std::string packed = readRaw(gzFile("map.gz", plain));
  for (const std::string& good : {plain, packed, toOtFile(map.octree())}) {
    std::mt19937 rng(51);
    std::vector<std::string> damaged(500, good);
    for (auto& bytes : damaged) bytes[rng() % bytes.size()] ^= static_cast<char>(1U << (rng() % 8));
    const auto results = resultsOf(damaged.size(), [&](size_t i) { return damaged[i]; });
    for (size_t i = 0; i < results.size(); i++)
      if (results[i] != kLoaded) {
        EXPECT_TRUE(saysWhatIsWrong(results[i], dir.path("cut"))) << i;
      }
  }
}

// ---------------------------------------------------------------- saving

TEST_F(MapFiles, SavesAMapInEveryFormatThatItLoads) {
  CProbOctoMap map(sceneTree(0.1, 4));
  map.insertionOptions.maxrange = 7;
  for (const char* name : {"a.ot", "a.probmap", "a.probmap.gz", "noextension"}) {
    saveMap(map, dir.path(name));
    EXPECT_TRUE(sameTree(map.octree(), loadMap(dir.path(name))->octree())) << name;
  }
  saveMap(map, dir.path("a.bt"));
  EXPECT_EQ(toOtFile(map.octree()), readRaw(dir.path("a.ot")));
  EXPECT_EQ(toBtFile(map.octree()), readRaw(dir.path("a.bt")));
  EXPECT_EQ(serialized(map), readRaw(dir.path("a.probmap")));
  EXPECT_EQ(7, loadMap(dir.path("a.probmap.gz"))->insertionOptions.maxrange);
  EXPECT_EQ("\x1f\x8b", readRaw(dir.path("a.probmap.gz")).substr(0, 2));
  EXPECT_EQ(5U, dir.files().size());
}

TEST_F(MapFiles, SavesTheOctomapOfASetAsAnOctree) {
  const auto ours = std::make_shared<CProbOctoMap>(smallTree());
  const auto set = several({CSimplePointsMap::Create(), ours});
  saveMap(set, dir.path("set.ot"));
  EXPECT_TRUE(sameTree(ours->octree(), loadMap(dir.path("set.ot"))->octree()));
  saveMap(set, dir.path("set.gz"));
  EXPECT_TRUE(sameTree(ours->octree(), loadMap(dir.path("set.gz"))->octree()));
  COctoMap theirs(0.1);
  ours->toOctoMap(theirs);
  saveMap(theirs, dir.path("theirs.ot"));
  EXPECT_TRUE(sameTree(ours->octree(), loadMap(dir.path("theirs.ot"))->octree()));
}

TEST_F(MapFiles, SavingLeavesTheMapAsItWas) {
  const CProbOctoMap map(sceneTree(0.1, 5));
  const auto before = nodesOf(map.octree());
  for (const char* name : {"a.ot", "a.bt", "a.gz", "a.map"}) saveMap(map, dir.path(name));
  EXPECT_TRUE(sameNodes(before, nodesOf(map.octree())));
}

TEST_F(MapFiles, AMapThatIsNoOctreeIsOnlySavedAsAnObject) {
  for (const char* name : {"points.ot", "points.bt"})
    EXPECT_TRUE(saysWhatIsWrong(errorOf([&] { saveMap(CSimplePointsMap(), dir.path(name)); }),
                                dir.path(name)));
  EXPECT_TRUE(dir.files().empty());
  saveMap(CSimplePointsMap(), dir.path("points.map"));
  EXPECT_TRUE(
      std::dynamic_pointer_cast<CSimplePointsMap>(deserialized(readRaw(dir.path("points.map")))));
}

TEST_F(MapFiles, ADestinationThatCannotBeWrittenIsNamedInTheError) {
  const CProbOctoMap map(smallTree());
  for (const char* name : {"none/a.ot", "none/a.bt", "none/a.gz", "none/a"})
    EXPECT_TRUE(saysWhatIsWrong(errorOf([&] { saveMap(map, dir.path(name)); }), dir.path(name)));
  EXPECT_TRUE(dir.files().empty());
}
