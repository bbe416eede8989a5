// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of a team whose maps change: its state is that of a fusion from scratch. */
#include <gtest/gtest.h>
#include <mrpt/fusion/many_maps.h>

#include <atomic>
#include <map>
#include <random>
#include <thread>

#include "fusion_core/features/features.h"
#include "fusion_octree/resampling.h"
#include "fusion_team/graph/fuse_with_memory.h"
#include "support/apartment_pair.h"
#include "support/tree_tools.h"

namespace mrpt::fusion::test::map_team_test {
namespace {

constexpr double kVoxel = 0.25;

/** The map of a robot that knows x from \a low to \a high (cells of 0.1 m) of the apartment. */
RobotMap robotMap(const std::string& robot, int low, int high, double yaw) {
  const auto map = transformOcTree(*apartment({low, 0, 0}, {high, 69, 25}),
                                   poseOf(-2, 1, 0.2, yaw, 0.2, 0.1), kVoxel);
  return {robot, PreparedMap(*map)};
}

/** Versions of the maps of four robots. */
const std::map<std::string, std::vector<RobotMap>>& versions() {
  static const std::map<std::string, std::vector<RobotMap>> all = {
      {"r1", {robotMap("r1", 0, 55, 0), robotMap("r1", 0, 70, 0)}},
      {"r2", {robotMap("r2", 25, 80, 40), robotMap("r2", 20, 85, 40)}},
      {"r3", {robotMap("r3", 45, 99, -70)}},
      {"r4", {robotMap("r4", 10, 90, 120), robotMap("r4", 5, 60, 10)}}};
  return all;
}

testing::AssertionResult sameState(const TeamState& state, const ManyFused& expected) {
  if (state.members.size() != expected.members.size())
    return testing::AssertionFailure() << "number of members";
  for (size_t k = 0; k < state.members.size(); k++) {
    const FusionMember &m = state.members[k], &e = expected.members[k];
    if (m.robot != e.robot || m.joined != e.joined || m.matched_with != e.matched_with ||
        m.counted_with != e.counted_with || m.links.size() != e.links.size() ||
        m.alignment.evaluation.reasons != e.alignment.evaluation.reasons)
      return testing::AssertionFailure() << m.robot << " versus " << e.robot;
    if (toEigen(m.pose.mean).matrix() != toEigen(e.pose.mean).matrix() ||
        m.pose.cov.asEigen() != e.pose.cov.asEigen())
      return testing::AssertionFailure() << "pose of " << m.robot;
    for (size_t i = 0; i < m.links.size(); i++)
      if (m.links[i].T_a_b.matrix() != e.links[i].T_a_b.matrix() ||
          m.links[i].covariance != e.links[i].covariance)
        return testing::AssertionFailure() << "link of " << m.robot;
  }
  if (!(state.sources == expected.sources)) return testing::AssertionFailure() << "sources";
  return map_tests::sameTree(*state.map, *expected.map);
}

TEST(MapTeam, IsEmptyAtFirst) {
  MapTeam team;
  EXPECT_EQ(team.state()->map, nullptr);
  EXPECT_FALSE(team.remove("r1"));
  team.set(versions().at("r1")[0]);
  EXPECT_TRUE(*team.state()->map == *versions().at("r1")[0].map.octree());
  EXPECT_TRUE(team.remove("r1"));
  EXPECT_EQ(team.state()->map, nullptr);
}

TEST(MapTeam, AfterAnyHistoryIsAsFromScratch) {
  MapTeam team;
  std::vector<RobotMap> maps;  // the model: what the team should hold
  std::mt19937 random(7);
  size_t joined = 0;
  for (int step = 0; step < 24; step++) {
    const std::string robot = "r" + std::to_string(1 + random() % 4);
    const auto held =
        std::find_if(maps.begin(), maps.end(), [&](const RobotMap& m) { return m.robot == robot; });
    if (held != maps.end() && random() % 3 == 0) {
      maps.erase(held);
      EXPECT_TRUE(team.remove(robot));
    } else {
      const auto& of_robot = versions().at(robot);
      const RobotMap& map = of_robot[random() % of_robot.size()];
      if (held != maps.end())
        *held = map;
      else
        maps.push_back(map);
      team.set(map);
    }
    if (maps.empty() || step % 2) continue;  // several changes at once
    const auto state = team.state();
    ASSERT_TRUE(sameState(*state, fuseMaps(maps, {}))) << "step " << step;
    for (const FusionMember& m : state->members) joined += m.joined ? 1 : 0;
  }
  EXPECT_GT(joined, 24U) << "most maps join";
}

TEST(MapTeam, AChangeMatchesThePairsOfTheChangedMapOnly) {
  std::vector<RobotMap> maps;
  for (const auto& [robot, of_robot] : versions()) maps.push_back(of_robot[0]);
  TeamMemory memory;
  size_t matches = 0;
  const auto fused = [&] {
    matches = 0;
    fuseWithMemory(maps, {}, memory, false, [&](const std::string&, size_t) { matches++; });
    memory.pairs.forgetUnused();
    return matches;
  };
  const size_t extractions = featureExtractions();
  EXPECT_EQ(fused(), 6U);
  EXPECT_EQ(fused(), 0U);
  maps[1] = versions().at("r2")[1];
  EXPECT_EQ(fused(), 3U);
  maps.pop_back();
  EXPECT_EQ(fused(), 0U);
  EXPECT_EQ(featureExtractions(), extractions) << "each map is prepared once";
}

TEST(MapTeam, AStateDoesNotChange) {
  MapTeam team;
  team.set(versions().at("r1")[0]);
  team.set(versions().at("r2")[0]);
  const auto state = team.state();
  EXPECT_EQ(team.state(), state) << "nothing has changed";
  const octomap::OcTree copy(*state->map);
  team.set(versions().at("r3")[0]);
  EXPECT_NE(team.state(), state);
  EXPECT_TRUE(map_tests::sameTree(copy, *state->map));
}

TEST(MapTeam, IsUsedByManyThreads) {
  MapTeam team;
  team.set(versions().at("r1")[0]);
  std::vector<std::thread> threads;
  std::atomic<size_t> states{0};
  for (const std::string robot : {"r2", "r3", "r4"})
    threads.emplace_back([&team, &states, robot] {
      team.set(versions().at(robot)[0]);
      if (team.state()->map) states++;
      if (robot == "r4") team.remove(robot);
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(states, 3U);
  std::vector<RobotMap> maps;
  for (const std::string& robot : team.robots()) maps.push_back(versions().at(robot)[0]);
  EXPECT_EQ(maps.size(), 3U);
  EXPECT_TRUE(sameState(*team.state(), fuseMaps(maps, {})));
}

TEST(FuseMaps, CountsNoObservationTwice) {
  RobotMap copy = versions().at("r2")[0];
  copy.robot = "s";
  const std::vector<RobotMap> two = {versions().at("r1")[0], versions().at("r2")[0]};
  std::vector<RobotMap> three = two;
  three.push_back(copy);
  const ManyFused expected = fuseMaps(two, {}), fused = fuseMaps(three, {});
  ASSERT_TRUE(fused.members[2].joined);
  EXPECT_EQ(fused.members[2].counting, Counting::Copy);
  EXPECT_EQ(fused.members[2].counted_with, "r2");
  EXPECT_EQ(fused.members[1].counting, Counting::All);
  // The fused map and one of its sources.
  const RobotMap fused_map{"f", PreparedMap(*expected.map).withSources(expected.sources)};
  const ManyFused again = fuseMaps({fused_map, two[1]}, {});
  ASSERT_TRUE(again.members[1].joined);
  EXPECT_EQ(again.members[1].counting, Counting::None);
  EXPECT_TRUE(map_tests::sameTree(*again.map, *expected.map));
  Options independent;
  independent.merge.independent = true;
  EXPECT_FALSE(*fuseMaps({fused_map, two[1]}, independent).map == *expected.map);
}

}  // namespace
}  // namespace mrpt::fusion::test::map_team_test
