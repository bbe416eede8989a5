// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of CObservationLocalMap. */

#include <mrpt/fusion/map_files.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/rtti/CObject.h>

#include "support/mrpt_tools.h"
using namespace map_tests;
using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationLocalMap;

namespace {

CObservationLocalMap::Ptr sent(const std::string& robot, uint64_t sequence,
                               mrpt::maps::CMetricMap::Ptr map) {
  auto o = CObservationLocalMap::Create();
  o->sensorLabel = robot;
  o->sequence = sequence;
  o->map = std::move(map);
  return o;
}

std::shared_ptr<CProbOctoMap> sceneMap(unsigned seed) {
  return std::make_shared<CProbOctoMap>(sceneTree(0.1, seed));
}

const octomap::OcTree& treeOf(const CObservationLocalMap& o) {
  return dynamic_cast<const CProbOctoMap&>(*o.map).octree();
}

}  // namespace

TEST(LocalMapObservation, KeepsAllOfIt) {
  CObservationLocalMap o;
  o.timestamp = mrpt::Clock::fromDouble(1700000000.25);
  o.sensorLabel = "robot 7";
  o.sequence = (uint64_t{1} << 40U) + 3;
  o.pose.mean = mrpt::poses::CPose3D(1, 2, 3, 0.4, 0.05, 0.06);
  o.pose.cov.setDiagonal(6, 0.25);
  o.pose.cov(0, 1) = o.pose.cov(1, 0) = 0.125;
  auto map = std::make_shared<CProbOctoMap>(awkwardTree(1 / 3.));
  mrpt::fusion::OcTreeAccess::setSensorModel(
      map->octree(), {-1.2345678F, 4.5678912F, 0.91234567F, -0.3456789F, 0.1234567F});
  map->insertionOptions.maxrange = 7.125;
  map->likelihoodOptions.decimation = 5;
  map->renderingOptions.generateGridLines = true;
  map->genericMapParams.enableObservationInsertion = false;
  o.map = map;

  const auto read = std::dynamic_pointer_cast<CObservationLocalMap>(deserialized(serialized(o)));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->timestamp, o.timestamp);
  EXPECT_EQ(read->sensorLabel, o.sensorLabel);
  EXPECT_EQ(read->sequence, o.sequence);
  EXPECT_EQ(read->pose.mean, o.pose.mean);
  EXPECT_EQ(read->pose.cov, o.pose.cov);
  const auto& m = dynamic_cast<const CProbOctoMap&>(*read->map);
  EXPECT_TRUE(sameTree(map->octree(), m.octree()));
  EXPECT_EQ(sensorModelBits(map->octree()), sensorModelBits(m.octree()));
  EXPECT_EQ(m.getResolution(), 1 / 3.);
  EXPECT_EQ(m.insertionOptions.maxrange, 7.125);
  EXPECT_EQ(m.likelihoodOptions.decimation, 5U);
  EXPECT_TRUE(m.renderingOptions.generateGridLines);
  EXPECT_FALSE(m.genericMapParams.enableObservationInsertion);
}

TEST(LocalMapObservation, AFreshOneKnowsNothingOfItsPose) {
  const CObservationLocalMap o;
  for (int i = 0; i < 6; i++) EXPECT_GE(o.pose.cov(i, i), 1e6);
  const auto read = std::dynamic_pointer_cast<CObservationLocalMap>(deserialized(serialized(o)));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->map, nullptr);
}

TEST(LocalMapObservation, BringsMapsOfOtherKindsToo) {
  auto points = std::make_shared<mrpt::maps::CSimplePointsMap>();
  points->insertPoint(1, 2, 3);
  const auto read = std::dynamic_pointer_cast<CObservationLocalMap>(
      deserialized(serialized(*sent("a", 1, points))));
  ASSERT_TRUE(read);
  const auto* same = dynamic_cast<const mrpt::maps::CSimplePointsMap*>(read->map.get());
  ASSERT_NE(same, nullptr);
  EXPECT_EQ(same->size(), 1U);
}

TEST(LocalMapObservation, ATruncatedStreamThrowsAndLeavesTheTargetAsItWas) {
  const std::string bytes = serialized(*sent("a", 5, std::make_shared<CProbOctoMap>(smallTree())));
  auto target = sent("b", 9, sceneMap(1));
  for (size_t n = 0; n + 1 < bytes.size(); n++) {
    ASSERT_ANY_THROW(deserializeInto(bytes.substr(0, n), *target)) << n << " of " << bytes.size();
    ASSERT_EQ(target->sensorLabel, "b");
    ASSERT_EQ(target->sequence, 9U);
  }
  EXPECT_TRUE(sameTree(treeOf(*target), *sceneTree(0.1, 1)));
  ASSERT_NO_THROW(deserializeInto(bytes, *target));
  EXPECT_EQ(target->sequence, 5U);
}

TEST(LocalMapObservation, ANewerVersionThrows) {
  std::string bytes = serialized(CObservationLocalMap());
  const std::string name = "CObservationLocalMap";
  const size_t version_at = bytes.find(name) + name.size();
  ASSERT_EQ(1, bytes[version_at]);
  bytes[version_at] = 2;
  CObservationLocalMap target;
  EXPECT_NE(errorOf([&] { deserializeInto(bytes, target); }).find("version"), std::string::npos);
}

TEST(LocalMapObservation, Version0IsReadAsBefore) {
  auto o = sent("a", 5, sceneMap(3));
  o->smallest = true;  // the only packing of version 0
  std::string bytes = serialized(*o);
  const std::string name = "CObservationLocalMap";
  bytes[bytes.find(name) + name.size()] = 0;
  CObservationLocalMap target;
  deserializeInto(bytes, target);
  EXPECT_EQ(target.sequence, 5U);
  EXPECT_TRUE(sameTree(treeOf(target), *sceneTree(0.1, 3)));
}

TEST(LocalMapObservation, KeepsThePackingWithWhichItCame) {
  auto o = sent("a", 5, sceneMap(3));
  const std::string fast = serialized(*o);
  o->smallest = true;
  const std::string smallest = serialized(*o);
  EXPECT_LT(smallest.size(), fast.size());
  for (const std::string& bytes : {fast, smallest}) {
    CObservationLocalMap target;
    deserializeInto(bytes, target);
    EXPECT_EQ(target.smallest, bytes == smallest);
    EXPECT_TRUE(serialized(target) == bytes);
    EXPECT_TRUE(sameTree(treeOf(target), *sceneTree(0.1, 3)));
  }
}

TEST(LocalMapObservation, FlippedBitsNeverCrash) {
  const std::string good = serialized(*sent("a", 5, std::make_shared<CProbOctoMap>(smallTree())));
  std::mt19937 rng(17);
  size_t errors = 0;
  for (int i = 0; i < 2000; i++) {
    std::string bytes = good;
    bytes[rng() % bytes.size()] ^= static_cast<char>(1U << (rng() % 8));
    CObservationLocalMap target;
    errors += !errorOf([&] { deserializeInto(bytes, target); }).empty();
  }
  EXPECT_GT(errors, 0U);
}

TEST(LocalMapObservation, DescribesItselfToPeople) {
  const auto o = sent("robot_a", 3, sceneMap(1));
  std::ostringstream text;
  o->getDescriptionAsText(text);
  for (const char* part : {"robot_a", "3", "Pose guess", "0.100 m", "Known space"})
    EXPECT_NE(text.str().find(part), std::string::npos) << part << " in\n" << text.str();
  EXPECT_TRUE(o->exportTxtSupported());
  const auto words = [](const std::string& line) {
    std::istringstream in(line.substr(0, line.find('"')));
    return std::vector<std::string>{std::istream_iterator<std::string>(in), {}};
  };
  EXPECT_EQ(words(o->exportTxtDataRow()).size() + 1, words(o->exportTxtHeader()).size());
}

TEST(LocalMapObservation, DescribesItselfWithoutControlCharacters) {
  std::ostringstream text;
  sent("a\033[31m\007", 3, nullptr)->getDescriptionAsText(text);
  for (const char c : text.str())
    EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= ' ') << static_cast<int>(c);
  EXPECT_NE(text.str().find("a\\x1b[31m\\x07"), std::string::npos) << text.str();
}

TEST(LocalMapObservation, IsRegistered) {
  const auto* id = mrpt::rtti::findRegisteredClass("mrpt::obs::CObservationLocalMap");
  ASSERT_NE(nullptr, id);
  EXPECT_TRUE(id->derivedFrom("mrpt::obs::CObservation"));
}

class Mission : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return dir_.path(name); }
  TempDir dir_;
};

TEST_F(Mission, HasTheLatestMapOfEachRobot) {
  for (const std::string name : {"mission.rawlog", "mission.rawlog.gz"}) {
    mrpt::fusion::saveLocalMaps({sent("a", 1, sceneMap(1)), sent("b", 4, sceneMap(4)),
                                 sent("a", 2, sceneMap(2)), sent("b", 3, sceneMap(3))},
                                file(name));
    const auto maps = mrpt::fusion::loadLocalMaps(file(name));
    ASSERT_EQ(maps.size(), 2U) << name;
    EXPECT_EQ(maps[0]->sensorLabel, "a");
    EXPECT_EQ(maps[1]->sensorLabel, "b");
    EXPECT_TRUE(sameTree(treeOf(*maps[0]), *sceneTree(0.1, 2)));
    EXPECT_TRUE(sameTree(treeOf(*maps[1]), *sceneTree(0.1, 4)));
  }
}

TEST_F(Mission, OfOneRobotIsAMap) {
  mrpt::fusion::saveLocalMaps({sent("a", 1, sceneMap(1)), sent("a", 2, sceneMap(2))}, file("a"));
  EXPECT_TRUE(sameTree(mrpt::fusion::loadMap(file("a"))->octree(), *sceneTree(0.1, 2)));
}

TEST_F(Mission, OfSeveralRobotsIsNotOneMap) {
  mrpt::fusion::saveLocalMaps({sent("a", 1, sceneMap(1)), sent("b", 1, sceneMap(2))}, file("ab"));
  EXPECT_EQ(errorOf([&] { mrpt::fusion::loadMap(file("ab")); }),
            file("ab") + ": holds the maps of 2 robots, not one map");
}

TEST_F(Mission, PrefersAWholeMapToAPartThatCameLater) {
  auto part = std::make_shared<mrpt::maps::CSimplePointsMap>();
  mrpt::fusion::saveLocalMaps({sent("a", 1, part), sent("a", 2, sceneMap(2)), sent("a", 3, part)},
                              file("a"));
  const auto maps = mrpt::fusion::loadLocalMaps(file("a"));
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0]->sequence, 2U);
}

TEST_F(Mission, OtherFilesHoldNone) {
  mrpt::fusion::saveMap(*sceneMap(1), file("map.ot"));
  mrpt::fusion::saveMap(*sceneMap(1), file("map.gz"));
  mrpt::io::CMemoryStream memory;
  mrpt::serialization::archiveFrom(memory) << mrpt::obs::CObservationOdometry();
  writeRaw(file("odometry.rawlog"), {static_cast<const char*>(memory.getRawBufferData()),
                                     static_cast<size_t>(memory.getTotalBytesCount())});
  for (const char* name : {"map.ot", "map.gz", "odometry.rawlog"})
    EXPECT_TRUE(mrpt::fusion::loadLocalMaps(file(name)).empty()) << name;
  EXPECT_EQ(errorOf([&] { mrpt::fusion::loadLocalMaps(file("none")); }).find(file("none") + ": "),
            0U);
}

TEST_F(Mission, TruncatedIsAnErrorWithItsPlace) {
  mrpt::fusion::saveLocalMaps({sent("a", 1, sceneMap(1)), sent("b", 1, sceneMap(2))}, file("ab"));
  const std::string bytes = readRaw(file("ab"));
  writeRaw(file("cut"), std::string_view(bytes).substr(0, bytes.size() - 100));
  EXPECT_NE(errorOf([&] { mrpt::fusion::loadLocalMaps(file("cut")); }).find("after 1 objects"),
            std::string::npos);
}
