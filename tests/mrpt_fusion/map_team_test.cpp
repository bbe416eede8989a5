// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the team of maps of a SLAM program, and of the sources of fused maps. */
#include <gtest/gtest.h>
#include <mrpt/fusion/fusion.h>
#include <mrpt/fusion/map_fusion.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/slam/CMapTeam.h>

#include <thread>

#include "support/apartment_pair.h"
#include "support/tree_tools.h"

namespace mrpt::fusion::test::map_team_test {
namespace {

using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationLocalMap;
using mrpt::slam::CMapTeam;

constexpr double kVoxel = 0.2;

const ApartmentPair& pair() {
  static const ApartmentPair maps(kVoxel);
  return maps;
}
CProbOctoMap mapA() { return CProbOctoMap(*pair().map_a); }
CProbOctoMap mapB() { return CProbOctoMap(*pair().map_b); }

CObservationLocalMap sent(const std::string& robot, uint64_t sequence, const CProbOctoMap& map) {
  CObservationLocalMap o;
  o.sensorLabel = robot;
  o.sequence = sequence;
  o.map = std::make_shared<CProbOctoMap>(map);
  return o;
}

TEST(MapTeamOfMrpt, HasTheResultOfFuse) {
  CMapTeam team;
  EXPECT_EQ(team.fusedMap(), nullptr);
  EXPECT_FALSE(team.member("a"));
  team.setMap("a", mapA());
  team.setMap("b", mapB());
  EXPECT_EQ(team.robots(), (std::vector<std::string>{"a", "b"}));
  const auto b = team.member("b");
  ASSERT_TRUE(b && b->joined);
  EXPECT_FALSE(b->alignment.evaluation.reasons.empty());
  EXPECT_LT(metresBetween(toEigen(b->pose.mean), pair().truth), kVoxel);
  EXPECT_GT(b->pose.cov(0, 0), 0);
  const auto expected = fuse(mapA(), mapB());
  const auto map = team.fusedMap();
  EXPECT_TRUE(map_tests::sameTree(map->octree(), expected.map().octree()));
  EXPECT_EQ(team.fusedMap(), map) << "nothing has changed";
  EXPECT_EQ(map->sources().size(), 2U);
  EXPECT_TRUE(team.removeMap("b"));
  EXPECT_FALSE(team.removeMap("b"));
  EXPECT_TRUE(map_tests::sameTree(team.fusedMap()->octree(), *pair().map_a));
}

TEST(MapTeamOfMrpt, TakesASnapshotOfAMap) {
  CMapTeam team;
  CProbOctoMap map = mapA();
  team.setMap("a", map);
  map.clear();
  EXPECT_TRUE(map_tests::sameTree(team.fusedMap()->octree(), *pair().map_a));
}

TEST(MapTeamOfMrpt, LateMessagesChangeNothing) {
  CMapTeam team;
  EXPECT_TRUE(team.setMap(sent("a", 5, mapA())));
  EXPECT_FALSE(team.setMap(sent("a", 4, mapB())));
  EXPECT_TRUE(team.setMap(sent("a", 6, mapB())));
  EXPECT_TRUE(map_tests::sameTree(team.fusedMap()->octree(), *pair().map_b));
  EXPECT_EQ(team.fusedMap()->sources()[0].sequence, 6U);
  EXPECT_TRUE(team.removeMap("a"));
  EXPECT_FALSE(team.setMap(sent("a", 6, mapB()))) << "it was removed";
  EXPECT_TRUE(team.setMap(sent("a", 7, mapA())));
}

TEST(MapTeamOfMrpt, RefusesMapsThatCannotBeFused) {
  CMapTeam team;
  EXPECT_ANY_THROW(team.setMap("a", CProbOctoMap(0.1)));
  EXPECT_ANY_THROW(team.setMap("a", mrpt::maps::CSimplePointsMap()));
  EXPECT_ANY_THROW(team.setMap(CObservationLocalMap()));
  EXPECT_TRUE(team.robots().empty());
}

TEST(MapTeamOfMrpt, ThreadsMayChangeItWhileOthersAsk) {
  CMapTeam team;
  team.setMap("a", mapA());
  std::thread asks([&team] {
    for (int i = 0; i < 5; i++) {
      EXPECT_NE(team.fusedMap(), nullptr);
      team.member("b");
    }
  });
  for (uint64_t i = 0; i < 5; i++) team.setMap(sent("b", i, mapB()));
  asks.join();
  EXPECT_TRUE(team.member("b")->joined);
}

TEST(SourcesOfFusedMaps, FusingAMapThatIsInItAddsNothing) {
  const CProbOctoMap ab = fuse(mapA(), mapB()).map();
  EXPECT_EQ(ab.sources().size(), 2U);
  const auto again = fuse(ab, mapB());
  ASSERT_TRUE(again.accepted());
  EXPECT_TRUE(map_tests::sameTree(again.map().octree(), ab.octree()));
  EXPECT_TRUE(map_tests::sameTree(fuse(mapA(), mapA()).map().octree(), *pair().map_a));
  mrpt::slam::CProbabilisticMapMatching matching;
  EXPECT_TRUE(map_tests::sameTree(matching.merge(mapA(), mapA(), {}).octree(), *pair().map_a));
  EXPECT_FALSE(map_tests::sameTree(
      matching.merge(mapA(), mapA(), mrpt::poses::CPose3D(3, 0, 0, 0, 0, 0)).octree(),
      *pair().map_a));
  matching.options.merge.independent = true;
  EXPECT_FALSE(map_tests::sameTree(matching.merge(mapA(), mapA(), {}).octree(), *pair().map_a));
}

TEST(SourcesOfFusedMaps, OfAMissionAreRobotsWithTheirSequences) {
  const mrpt::slam::CProbabilisticMapMatching matching;
  const auto a = std::make_shared<CObservationLocalMap>(sent("a", 3, mapA())),
             b = std::make_shared<CObservationLocalMap>(sent("b", 9, mapB()));
  const FusionResult fused = fuseMaps(matching, {a, b});
  const Sources sources = fused.map.sources();
  ASSERT_EQ(sources.size(), 2U);
  EXPECT_EQ(sources[0].robot, "a");
  EXPECT_EQ(sources[0].sequence, 3U);
  EXPECT_EQ(sources[1].robot, "b");
  EXPECT_EQ(sources[1].sequence, 9U);
  // The fused map is sent, and meets one of its maps.
  const auto f = std::make_shared<CObservationLocalMap>(sent("f", 1, fused.map));
  const FusionResult again = fuseMaps(matching, {f, b});
  ASSERT_TRUE(again.members[1].joined);
  EXPECT_EQ(again.members[1].counting, Counting::None);
  EXPECT_EQ(again.members[1].counted_with, "f");
  EXPECT_TRUE(map_tests::sameTree(again.map.octree(), fused.map.octree()));
  EXPECT_EQ(again.map.sources(), sources);
}

}  // namespace
}  // namespace mrpt::fusion::test::map_team_test
