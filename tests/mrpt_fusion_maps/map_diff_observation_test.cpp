// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of CObservationMapDiff, and of missions that hold such observations. */

#include <mrpt/fusion/map_files.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/rtti/CObject.h>

#include "fusion_link/map_index.h"
#include "fusion_octree/compression.h"
#include "mrpt_fusion_maps/recordings/crafted.h"
#include "support/mrpt_tools.h"
#include "support/test_maps.h"

using namespace map_tests;
using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationMapDiff;

namespace mrpt::fusion::test::map_diff_observation_test {
namespace {

/** Versions of a map that grows, and that has another sensor model than a new map. */
class GrowingMap {
 public:
  GrowingMap() {
    OcTreeAccess::setSensorModel(*tree_,
                                 {-1.2345678F, 4.5678912F, 0.91234567F, -0.3456789F, 0.1234567F});
  }
  /** Returns the next version: some voxels near a corner differ. */
  const octomap::OcTree& grow() {
    for (int i = 0; i < 40; i++)
      putVoxel(*tree_, {50 + i % 8, 40 + steps_, -20 + i / 8},
               0.1F * static_cast<float>(i + steps_));
    finish(*tree_);
    steps_++;
    return *tree_;
  }
  const octomap::OcTree& tree() const { return *tree_; }

 private:
  std::unique_ptr<octomap::OcTree> tree_ = randomTree();
  int steps_ = 0;
};

testing::AssertionResult isSame(const octomap::OcTree& a, const octomap::OcTree& b) {
  if (sensorModelBits(a) != sensorModelBits(b))
    return testing::AssertionFailure() << "the sensor models differ";
  return sameTree(a, b);
}

const octomap::OcTree& treeOf(const mrpt::maps::CMetricMap& map) {
  return dynamic_cast<const CProbOctoMap&>(map).octree();
}

CObservationMapDiff::Ptr afterStream(const CObservationMapDiff& diff) {
  return std::dynamic_pointer_cast<CObservationMapDiff>(deserialized(serialized(diff)));
}

class MapDiffMission : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const Objects& objects) const {
    writeRaw(dir_.path(name), map_tests::bytesOf(objects));
    return dir_.path(name);
  }
  TempDir dir_;
};

}  // namespace

TEST(MapDiffObservation, GivesEachVersionOfTheMapBitForBit) {
  GrowingMap map;
  MapDiffs diffs("r1");
  CProbOctoMap copy(0.3);  // the diffs bring the resolution
  size_t all = 0;
  for (int step = 0; step < 4; step++) {
    const auto diff = diffs.next(map.grow());
    ASSERT_TRUE(diff);
    EXPECT_EQ(diff->sensorLabel, "r1");
    if (step == 0) all = diff->blocks.size();
    if (step > 0) {
      EXPECT_LT(diff->blocks.size(), all / 4);
    }
    EXPECT_TRUE(copy.insertObservation(*afterStream(*diff)));
    EXPECT_TRUE(isSame(copy.octree(), map.tree())) << step;
  }
  EXPECT_GT(all, 8U);
  EXPECT_EQ(diffs.next(map.tree()), nullptr);
}

TEST(MapDiffObservation, KeepsAllOfIt) {
  MapDiffs diffs("robot 7");
  const auto diff = diffs.next(*smallTree());
  diff->timestamp = mrpt::Clock::fromDouble(1700000000.25);
  const auto read = afterStream(*diff);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->timestamp, diff->timestamp);
  EXPECT_EQ(read->sensorLabel, "robot 7");
  EXPECT_EQ(read->version, diff->version);
  EXPECT_TRUE(serialized(*read) == serialized(*diff));
}

TEST(MapDiffObservation, IsInsertedAgainWithoutEffect) {
  GrowingMap map;
  MapDiffs diffs("r1");
  const auto first = diffs.next(map.grow()), second = diffs.next(map.grow());
  CProbOctoMap copy;
  for (const auto& diff : {first, second, second}) copy.insertObservation(*diff);
  EXPECT_TRUE(isSame(copy.octree(), map.tree()));
}

TEST(MapDiffObservation, WithoutTheDiffsBeforeItIsNotInserted) {
  GrowingMap map;
  MapDiffs diffs("r1");
  diffs.next(map.grow());
  const auto second = diffs.next(map.grow());
  CProbOctoMap copy;
  EXPECT_FALSE(copy.insertObservation(*second));
  EXPECT_TRUE(copy.isEmpty());
}

TEST(MapDiffObservation, OfAnotherRobotOrIntoAnotherMapIsNotInserted) {
  const auto small = smallTree();
  const auto of_r1 = MapDiffs("r1").next(*sceneTree(0.1, 1)), of_r2 = MapDiffs("r2").next(*small);
  CProbOctoMap copy;
  EXPECT_TRUE(copy.insertObservation(*of_r1));
  EXPECT_FALSE(copy.insertObservation(*of_r2));
  EXPECT_TRUE(sameTree(copy.octree(), *sceneTree(0.1, 1)));
  copy.clear();
  EXPECT_TRUE(copy.insertObservation(*of_r2));
  EXPECT_TRUE(sameTree(copy.octree(), *small));
  CProbOctoMap other(*small);
  EXPECT_FALSE(other.insertObservation(*of_r1));
  EXPECT_TRUE(sameTree(other.octree(), *small));
}

TEST(MapDiffObservation, IsInsertedInACopyOfTheMap) {
  GrowingMap map;
  MapDiffs diffs("r1");
  CProbOctoMap first;
  first.insertObservation(*diffs.next(map.grow()));
  const octomap::OcTree before(map.tree());
  CProbOctoMap copy(first);
  EXPECT_TRUE(copy.insertObservation(*diffs.next(map.grow())));
  EXPECT_TRUE(isSame(copy.octree(), map.tree()));
  EXPECT_TRUE(isSame(first.octree(), before));
}

TEST(MapDiffObservation, WithBlocksOfAnotherMapThrowsAndTheMapStays) {
  const auto diff = MapDiffs("r1").next(*sceneTree(0.1, 1));
  auto wrong = *diff;
  wrong.blocks.front().nodes = MapDiffs("r1").next(*sceneTree(0.1, 2))->blocks.front().nodes;
  CProbOctoMap map;
  map.insertObservation(*diff);
  EXPECT_NE(errorOf([&] { map.insertObservation(wrong); }).find("corrupt"), std::string::npos);
  EXPECT_TRUE(sameTree(map.octree(), *sceneTree(0.1, 1)));
}

TEST(MapDiffObservation, WithManyBlocksThatItsIndexDoesNotNameIsRefused) {
  constexpr size_t kBlocks = 10000;
  octomap::OcTree voxel(0.1);
  const std::string nodes =
      compressNodes(*OcTreeAccess::createRoot(voxel), OcTreeCube::kMaxDepth, Packing::Fast);
  MapIndex index;
  index.version = 1;
  index.trunk.resolution = 0.1;
  CObservationMapDiff diff;
  diff.version = index.version;
  const BlockCode first = codeOf({{0, 0, 0}, OcTreeCube::kMaxDepth});
  for (BlockCode code = first; code < first + 2 * kBlocks; code++) {
    if (code < first + kBlocks) index.blocks[code] = index.version;
    diff.blocks.push_back({code, index.version, nodes});
  }
  diff.index = toBytes(index);
  const auto read = afterStream(diff);
  CProbOctoMap map;
  EXPECT_NE(errorOf([&] { map.insertObservation(*read); }).find("corrupt"), std::string::npos);
}

TEST(MapDiffObservation, ATruncatedStreamThrowsAndLeavesTheTargetAsItWas) {
  const std::string bytes = serialized(*MapDiffs("a").next(*smallTree()));
  CObservationMapDiff target;
  target.sensorLabel = "b";
  for (size_t n = 0; n + 1 < bytes.size(); n++) {
    ASSERT_ANY_THROW(deserializeInto(bytes.substr(0, n), target)) << n << " of " << bytes.size();
    ASSERT_EQ(target.sensorLabel, "b");
  }
  ASSERT_NO_THROW(deserializeInto(bytes, target));
  EXPECT_EQ(target.sensorLabel, "a");
}

TEST(MapDiffObservation, FlippedBitsNeverCrash) {
  const std::string good = serialized(*MapDiffs("a").next(*smallTree()));
  std::mt19937 rng(17);
  size_t errors = 0;
  for (int i = 0; i < 2000; i++) {
    std::string bytes = good;
    bytes[rng() % bytes.size()] ^= static_cast<char>(1U << (rng() % 8));
    CObservationMapDiff target;
    CProbOctoMap map;
    errors += !errorOf([&] {
                 deserializeInto(bytes, target);
                 map.insertObservation(target);
               }).empty();
  }
  EXPECT_GT(errors, 1000U);
}

TEST(MapDiffObservation, DescribesItselfWithoutControlCharacters) {
  std::ostringstream text;
  MapDiffs("a\033[31m").next(*smallTree())->getDescriptionAsText(text);
  EXPECT_NE(text.str().find("robot 'a\\x1b[31m'"), std::string::npos) << text.str();
  EXPECT_NE(text.str().find("Blocks that have changed: "), std::string::npos) << text.str();
  EXPECT_EQ(text.str().find('\033'), std::string::npos);
}

TEST_F(MapDiffMission, HasTheLatestMapOfEachRobot) {
  GrowingMap map;
  MapDiffs r1("r1"), r2("r2");
  const auto second_map = sceneTree(0.1, 4);
  Objects objects{r2.next(*sceneTree(0.1, 3)), r1.next(map.grow()), r1.next(map.grow())};
  objects.push_back(r2.next(*second_map));
  const auto latest = dynamic_cast<CObservationMapDiff&>(*objects[2]).version;
  const auto maps = loadLocalMaps(write("mission.rawlog", objects));
  ASSERT_EQ(maps.size(), 2U);
  EXPECT_EQ(maps[0]->sensorLabel, "r2");
  EXPECT_TRUE(isSame(treeOf(*maps[0]->map), *second_map));
  EXPECT_EQ(maps[1]->sensorLabel, "r1");
  EXPECT_TRUE(isSame(treeOf(*maps[1]->map), map.tree()));
  EXPECT_EQ(maps[1]->sequence, latest);
  EXPECT_EQ(maps[1]->timestamp, dynamic_cast<CObservationMapDiff&>(*objects[2]).timestamp);
  const auto sources = dynamic_cast<const CProbOctoMap&>(*maps[1]->map).sources();
  ASSERT_EQ(sources.size(), 1U);
  EXPECT_EQ(sources[0].robot, "r1");
}

TEST_F(MapDiffMission, OfOneRobotIsAMapAndIsBuilt) {
  GrowingMap map;
  MapDiffs diffs("r1");
  const Objects objects{diffs.next(map.grow()), diffs.next(map.grow())};
  const std::string path = write("mission.rawlog", objects);
  EXPECT_TRUE(isSame(loadMap(path)->octree(), map.tree()));
  const BuiltMap built = buildMap(path);
  EXPECT_TRUE(isSame(treeOf(*built.map), map.tree()));
  EXPECT_EQ(built.inserted, 2U);
  EXPECT_EQ(built.ignored, 0U);
}

TEST_F(MapDiffMission, OfSeveralRobotsIsNotBuilt) {
  const std::string path = write("mission.rawlog", {MapDiffs("r1").next(*sceneTree(0.1, 1)),
                                                    MapDiffs("r2").next(*sceneTree(0.1, 2))});
  EXPECT_EQ(errorOf([&] { buildMap(path); }), path + ": holds the maps of 2 robots, not one map");
}

TEST_F(MapDiffMission, ARobotThatWasRestartedSendsItsMapAnew) {
  GrowingMap map;
  MapDiffs before("r1"), after("r1");
  Objects objects;
  for (int i = 0; i < 3; i++) objects.push_back(before.next(map.grow()));
  const auto small = sceneTree(0.1, 5);
  objects.push_back(after.next(*small));
  EXPECT_TRUE(isSame(loadMap(write("mission.rawlog", objects))->octree(), *small));
}

TEST_F(MapDiffMission, WithoutItsBeginningIsAnError) {
  GrowingMap map;
  MapDiffs diffs("r1");
  diffs.next(map.grow());
  const std::string path = write("mission.rawlog", {diffs.next(map.grow())});
  const std::string error = errorOf([&] { loadLocalMaps(path); });
  EXPECT_EQ(error.find(path + ": the map of r1 is not whole: "), 0U) << error;
}

TEST_F(MapDiffMission, InARecordingWithScansIsLeftOutOfTheMapOfTheScans) {
  const auto diff = MapDiffs("r1").next(*sceneTree(0.1, 1));
  const std::string path =
      write("scans.rawlog", {stamped(diff, 0.5), robotPoseAt(0), cloudAt(1), robotPoseAt(2)});
  const BuiltMap built = buildMap(path);
  EXPECT_TRUE(sameTree(treeOf(*built.map), mapOfClouds({1}).octree()));
  ASSERT_EQ(built.left_out.size(), 1U);
  EXPECT_EQ(built.left_out[0].kind, "CObservationMapDiff");
}

}  // namespace mrpt::fusion::test::map_diff_observation_test
