// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the exchange of maps over a bad network. */
#include "fusion_link/team_exchange.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "fusion_base/byte_writer.h"
#include "fusion_link/simulated_network.h"
#include "support/file_tools.h"
#include "support/tree_tools.h"

using namespace map_tests;

namespace mrpt::fusion::test::team_exchange_test {
namespace {

using Map = std::shared_ptr<const octomap::OcTree>;
using Port = SimulatedNetwork::Port;

constexpr SimulatedNetwork::Quality kGood{0, 1000};
constexpr SimulatedNetwork::Quality kBad{0.6, 4};

/** A map of \a rooms rooms full of clutter. */
Map clutter(unsigned seed, int rooms) {
  auto tree = std::make_shared<octomap::OcTree>(0.1);
  std::mt19937 random(seed);
  for (int i = 0; i < 5000 * rooms; i++)
    putVoxel(*tree,
             {static_cast<int>(random() % 30) + 40 * (i / 5000), static_cast<int>(random() % 30),
              static_cast<int>(random() % 20)},
             static_cast<float>(random() % 1000) / 300 - 1);
  finish(*tree);
  return tree;
}

/** Returns whether an exchange has the whole map of a robot. */
testing::AssertionResult has(const TeamExchange& exchange, const std::string& robot,
                             const Map& map) {
  const auto found = exchange.maps().find({robot, ""});
  if (found == exchange.maps().end()) return testing::AssertionFailure() << "no map of " << robot;
  if (found->second.completeVersion() == 0)
    return testing::AssertionFailure() << robot << " is not complete";
  return sameTree(*map, *joinBlocks(*found->second.blocks()));
}

/** A robot on a network. */
struct Robot {
  Robot(SimulatedNetwork& network, const std::string& name, const std::string& journal = {},
        const ExchangeLimits& limits = {})
      : port(network.connect(name)), exchange(name, *port, journal, limits) {}
  std::unique_ptr<Port> port;
  TeamExchange exchange;
};

void run(SimulatedNetwork& network, const std::vector<Robot*>& robots, int steps) {
  for (int i = 0; i < steps; i++) {
    for (Robot* robot : robots) robot->exchange.step();
    network.step();
  }
}

TEST(TeamExchange, AllRobotsGetAllMapsOverABadNetwork) {
  const std::vector<Map> maps = {clutter(1, 2), clutter(2, 2), clutter(3, 1)};
  SimulatedNetwork network(1, kBad);
  Robot a(network, "a"), b(network, "b"), c(network, "c");
  const std::vector<Robot*> robots = {&a, &b, &c};
  for (size_t i = 0; i < 3; i++) robots[i]->exchange.publish(maps[i]);
  run(network, robots, 100);
  for (const Robot* robot : robots) {
    EXPECT_TRUE(has(robot->exchange, "a", maps[0]));
    EXPECT_TRUE(has(robot->exchange, "b", maps[1]));
    EXPECT_TRUE(has(robot->exchange, "c", maps[2]));
    EXPECT_EQ(robot->exchange.refused(), 0U);
  }
  EXPECT_EQ(a.exchange.acknowledged().at("b"), a.exchange.maps().at({"a", ""}).completeVersion());
}

TEST(TeamExchange, MapsMayChangeDuringAPartitionAndALateRobotGetsThemToo) {
  SimulatedNetwork network(2, kBad);
  Robot a(network, "a"), b(network, "b");
  a.exchange.publish(clutter(1, 1));
  b.exchange.publish(clutter(2, 1));
  run(network, {&a, &b}, 60);
  network.separate(*a.port, *b.port, true);
  for (int rooms = 2; rooms <= 3; rooms++) {
    a.exchange.publish(clutter(1, rooms));
    run(network, {&a, &b}, 20);
  }
  EXPECT_TRUE(has(b.exchange, "a", clutter(1, 1)));
  network.separate(*a.port, *b.port, false);
  Robot late(network, "late");
  run(network, {&a, &b, &late}, 100);
  for (const Robot* robot : {&b, &late}) {
    EXPECT_TRUE(has(robot->exchange, "a", clutter(1, 3)));
    EXPECT_TRUE(has(robot->exchange, "b", clutter(2, 1)));
  }
}

TEST(TeamExchange, NothingIsSentTwiceAfterAPartition) {
  SimulatedNetwork network(14, {0, 1});
  Robot a(network, "a"), b(network, "b");
  const Map map = clutter(1, 8);
  a.exchange.publish(map);
  size_t all = 0;
  for (const auto& block : divideIntoBlocks(*map).blocks) all += block.second->size();
  const auto sent = [&] { return network.bytes(*a.port, *b.port); };
  for (int partition = 0; partition < 4; partition++) {
    run(network, {&a, &b}, 4);  // a part of the map arrives
    EXPECT_FALSE(has(b.exchange, "a", map));
    network.separate(*a.port, *b.port, true);
    run(network, {&a, &b}, 20);
    network.separate(*a.port, *b.port, false);
  }
  run(network, {&a, &b}, 50);
  EXPECT_TRUE(has(b.exchange, "a", map));
  EXPECT_LT(sent(), all + all / 20 + 4 * kMostMessageBytes);  // what was lost on its way
  const size_t before = sent();
  network.separate(*a.port, *b.port, true);
  run(network, {&a, &b}, 20);
  network.separate(*a.port, *b.port, false);
  run(network, {&a, &b}, 20);
  EXPECT_LT(sent() - before, 200U);  // what the robots have of each other's maps
}

TEST(TeamExchange, AStandingRobotSendsNothing) {
  SimulatedNetwork network(3, kGood);
  Robot a(network, "a"), b(network, "b");
  a.exchange.publish(clutter(1, 2));
  run(network, {&a, &b}, 10);
  const size_t bytes = network.bytes(*a.port, *b.port) + network.bytes(*b.port, *a.port);
  a.exchange.publish(clutter(1, 2));
  run(network, {&a, &b}, 50);
  EXPECT_EQ(network.bytes(*a.port, *b.port) + network.bytes(*b.port, *a.port), bytes);
}

TEST(TeamExchange, AChangeCostsWhatChanged) {
  SimulatedNetwork network(4, kGood);
  Robot a(network, "a"), b(network, "b");
  a.exchange.publish(clutter(1, 8));
  run(network, {&a, &b}, 10);
  auto map = std::make_shared<octomap::OcTree>(*clutter(1, 8));
  for (int i = 0; i < 15; i++) putVoxel(*map, {i, 14, 10}, 3.4F);
  finish(*map);
  const size_t bytes = network.bytes(*a.port, *b.port);
  a.exchange.publish(map);
  run(network, {&a, &b}, 10);
  EXPECT_TRUE(has(b.exchange, "a", map));
  size_t changed = 0;
  const auto& own = a.exchange.maps().at({"a", ""});
  const MapBlocks blocks = *own.blocks();
  for (const auto& [code, block] : blocks.blocks)
    if (own.versionOf(code) == own.completeVersion()) changed += block->size();
  EXPECT_GT(changed, 0U);
  EXPECT_LE(network.bytes(*a.port, *b.port) - bytes, changed + 1500);  // and the index
}

TEST(TeamExchange, WantedBlocksComeFirst) {
  SimulatedNetwork network(5, {0, 1});
  Robot a(network, "a"), b(network, "b");
  run(network, {&a, &b}, 3);
  const Map map = clutter(1, 8);
  const MapBlocks blocks = divideIntoBlocks(*map);
  ASSERT_GT(blocks.blocks.size(), 20U);
  const std::vector<BlockCode> last = {std::prev(blocks.blocks.end())->first,
                                       std::prev(blocks.blocks.end(), 2)->first};
  a.exchange.publish(map);
  run(network, {&a, &b}, 2);  // the index has arrived
  b.exchange.want({{{"a", ""}, last}});
  run(network, {&a, &b}, 3);
  const MapReplica& replica = b.exchange.maps().at({"a", ""});
  EXPECT_GT(replica.missing().size(), 5U);
  for (const BlockCode code : last) EXPECT_EQ(replica.missing().count(code), 0U) << code;
}

TEST(TeamExchange, ARobotContinuesFromItsJournal) {
  SimulatedNetwork network(6, kGood);
  Robot a(network, "a");
  const TempDir folder;
  const std::string journal = folder.path("b");
  uint64_t own_version = 0;
  {
    Robot b(network, "b", journal);
    a.exchange.publish(clutter(1, 2));
    b.exchange.publish(clutter(2, 1));
    run(network, {&a, &b}, 10);
    ASSERT_TRUE(has(b.exchange, "a", clutter(1, 2)));
    own_version = b.exchange.maps().at({"b", ""}).completeVersion();
  }
  SimulatedNetwork nobody(7, kGood);  // a is out of reach
  Robot b(nobody, "b", journal);
  EXPECT_TRUE(has(b.exchange, "a", clutter(1, 2)));
  EXPECT_TRUE(has(b.exchange, "b", clutter(2, 1)));
  b.exchange.publish(clutter(2, 1));
  EXPECT_EQ(b.exchange.maps().at({"b", ""}).completeVersion(), own_version);
  EXPECT_THROW(Robot(nobody, "b", journal), std::runtime_error);  // the journal is in use
}

TEST(TeamExchange, NoAcknowledgedSampleIsLostWhereverTheJournalIsCut) {
  const TempDir folder;
  const std::string journal = folder.path("b"), file = folder.path("b/samples");
  std::vector<std::pair<size_t, size_t>> states;  // bytes of the file, samples acknowledged
  {
    SimulatedNetwork network(8, {0.3, 1});
    Robot a(network, "a"), b(network, "b", journal);
    a.exchange.publish(clutter(1, 3));
    for (int i = 0; i < 60; i++) {
      run(network, {&a, &b}, 1);
      const auto map = b.exchange.maps().find({"a", ""});
      if (map != b.exchange.maps().end())
        states.emplace_back(std::filesystem::file_size(file), map->second.samples().size());
    }
    ASSERT_TRUE(has(b.exchange, "a", clutter(1, 3)));
  }
  const std::string bytes = readRaw(file);
  std::mt19937 random(9);
  for (int i = 0; i < 100; i++) {  // a crash leaves what was synced, and any part of the rest
    const auto& [size, samples] = states[random() % states.size()];
    const size_t rest = random() % (bytes.size() - size + 1);
    writeRaw(file, bytes.substr(0, size + rest) + std::string(random() % 3, '\x07'));
    SimulatedNetwork nobody(7, kGood);
    Robot b(nobody, "b", journal);
    const auto map = b.exchange.maps().find({"a", ""});
    ASSERT_NE(map, b.exchange.maps().end());
    EXPECT_GE(map->second.samples().size(), samples);
  }
}

TEST(TeamExchange, TheJournalStaysSmall) {
  const TempDir folder;
  SimulatedNetwork network(10, kGood);
  Robot a(network, "a"), b(network, "b", folder.path("b"));
  size_t sent = 0;
  for (unsigned i = 0; i < 60; i++) {
    a.exchange.publish(clutter(i, 3));
    run(network, {&a, &b}, 4);
    sent = network.bytes(*a.port, *b.port);
  }
  const size_t live = b.exchange.maps().at({"a", ""}).bytes();
  EXPECT_GT(sent, 3'000'000U);
  EXPECT_LE(std::filesystem::file_size(folder.path("b/samples")), 2 * live + 1'200'000);
  EXPECT_TRUE(has(b.exchange, "a", clutter(59, 3)));
}

TEST(TeamExchange, AfterAMissionARobotHoldsNoMoreThanARobotThatComesNow) {
  constexpr int kVersions = 40;
  constexpr int kReach = 120;  // voxels
  SimulatedNetwork network(17, {0.2, 8});
  std::vector<std::unique_ptr<Robot>> team;
  std::vector<Robot*> robots;
  std::vector<octomap::OcTree> maps(4, octomap::OcTree(0.1));
  for (const char* name : {"a", "b", "c", "d"})
    robots.push_back(team.emplace_back(std::make_unique<Robot>(network, name)).get());
  std::mt19937 random(3);
  for (int version = 0; version < kVersions; version++) {
    // They drive to and fro. What they see again changes, too.
    const int x = std::abs((8 * version) % (2 * kReach) - kReach);
    for (size_t r = 0; r < robots.size(); r++) {
      for (int i = 0; i < 2000; i++)
        putVoxel(maps[r],
                 {x + static_cast<int>(random() % 20), static_cast<int>(random() % 20),
                  static_cast<int>(random() % 20)},
                 static_cast<float>(random() % 1000) / 300 - 1);
      finish(maps[r]);
      robots[r]->exchange.publish(std::make_shared<octomap::OcTree>(maps[r]));
    }
    network.separate(*robots[0]->port, *robots[1]->port, version % 20 > 12);
    run(network, robots, 4);
  }
  network.separate(*robots[0]->port, *robots[1]->port, false);
  Robot late(network, "late");
  robots.push_back(&late);
  run(network, robots, 200);
  for (const Robot* robot : robots)
    for (size_t r = 0; r < maps.size(); r++) {
      const std::string name(1, static_cast<char>('a' + r));
      EXPECT_TRUE(has(robot->exchange, name, std::make_shared<octomap::OcTree>(maps[r])));
      EXPECT_EQ(robot->exchange.maps().at({name, ""}).bytes(),
                late.exchange.maps().at({name, ""}).bytes())
          << name;
      EXPECT_FALSE(robot->exchange.isWaiting());
    }
}

TEST(TeamExchange, ARobotWithoutAJournalContinuesAboveItsOldVersions) {
  SimulatedNetwork network(11, kGood);
  Robot b(network, "b");
  {
    Robot a(network, "a");
    for (int rooms = 1; rooms <= 3; rooms++) {
      a.exchange.publish(clutter(1, rooms));
      run(network, {&a, &b}, 5);
    }
  }
  for (int lost = 1; lost <= 4; lost++) {  // as many versions as before, fewer, or more
    Robot a(network, "a");
    network.separate(*a.port, *b.port, true);
    for (int i = 0; i < lost; i++) a.exchange.publish(clutter(20 + static_cast<unsigned>(i), 2));
    run(network, {&a, &b}, 5);
    network.separate(*a.port, *b.port, false);
    run(network, {&a, &b}, 20);
    EXPECT_TRUE(has(b.exchange, "a", clutter(19 + static_cast<unsigned>(lost), 2))) << lost;
  }
}

TEST(TeamExchange, HostileSamplesAreCountedAndMemoryIsBounded) {
  ExchangeLimits limits;
  limits.maps = 4;
  limits.bytes_of_map = 300'000;
  limits.bytes = 500'000;
  SimulatedNetwork network(12, {0, 1'000'000});
  Robot a(network, "a", {}, limits), b(network, "b", {}, limits);
  const auto hostile = network.connect("h0");
  std::mt19937 random(13);
  const std::string block = *divideIntoBlocks(*clutter(1, 1)).blocks.begin()->second;
  for (int i = 0; i < 3000; i++) {
    Sample s;
    s.key.source = {"h" + std::to_string(random() % 9), random() % 4 ? "" : "m"};
    if (random() % 50 == 0) s.key.source.robot = "a";
    if (random() % 50 == 0) s.key.source.robot = "\x1b[31m";
    if (random() % 50 == 0) s.key.source.robot.assign(1000, 'n');
    s.key.kind = static_cast<SampleKind>(random() % 6);
    s.key.number = random() % 2 ? random() : random() % 3;
    s.version = random() % 2 ? std::numeric_limits<uint64_t>::max() - random() % 2 : random();
    if (random() % 2) {
      s.bytes.resize(random() % 200);
      for (char& c : s.bytes) c = static_cast<char>(random());
    } else if (random() % 2) {
      s.bytes = block;
    } else {
      s.bytes.assign(100'000, 'x');
    }
    const std::string bytes = toBytes(s).substr(0, kMostMessageBytes - 2);
    std::string message;
    appendValue(static_cast<uint16_t>(bytes.size() + random() % 10 / 9), message);
    message += bytes;
    hostile->send("a", message);
    hostile->send("b", message);
  }
  a.exchange.publish(clutter(1, 1));
  b.exchange.publish(clutter(2, 1));
  run(network, {&a, &b}, 40);
  EXPECT_GT(a.exchange.refused(), 1000U);
  EXPECT_FALSE(a.exchange.takeReason().empty());
  EXPECT_TRUE(a.exchange.takeReason().empty());
  EXPECT_LE(a.exchange.maps().size(), limits.maps);
  size_t bytes = 0;
  for (const auto& map : a.exchange.maps()) bytes += map.second.bytes();
  EXPECT_LE(bytes, limits.bytes);
  EXPECT_TRUE(has(a.exchange, "a", clutter(1, 1)));
}

}  // namespace
}  // namespace mrpt::fusion::test::team_exchange_test
