// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of what robots make of the maps that arrive. */
#include "fusion_link/team_view.h"

#include <gtest/gtest.h>

#include "fusion_link/outline.h"
#include "fusion_link/simulated_network.h"
#include "fusion_link/team_exchange.h"
#include "fusion_link/wanted.h"
#include "fusion_octree/compression.h"
#include "support/apartment_pair.h"
#include "support/tree_tools.h"

namespace mrpt::fusion::test::team_view_test {
namespace {

using Map = std::shared_ptr<const octomap::OcTree>;

constexpr double kVoxel = 0.25;

/** The map of a robot that knows x from \a low to \a high (cells of 0.1 m) of the apartment. */
Map part(int low, int high, double yaw) {
  return transformOcTree(*apartment({low, 0, 0}, {high, 69, 25}), poseOf(-2, 1, 0.2, yaw, 0.2, 0.1),
                         kVoxel);
}

std::vector<MapSnapshot> snapshotsOf(const TeamExchange& exchange) {
  std::vector<MapSnapshot> snapshots;
  for (const auto& map : exchange.maps()) snapshots.emplace_back(map.second);
  return snapshots;
}

/** A robot that thinks after each step. */
struct Robot {
  Robot(SimulatedNetwork& network, const std::string& name)
      : port(network.connect(name)), exchange(name, *port), view(name, {}) {}

  void step() {
    if (exchange.step() || !knowledge) think();
  }
  void think() {
    knowledge = view.update(snapshotsOf(exchange));
    exchange.want(knowledge->wanted);
  }

  std::unique_ptr<SimulatedNetwork::Port> port;
  TeamExchange exchange;
  TeamView view;
  std::optional<TeamKnowledge> knowledge;
};

TEST(TeamView, AllRobotsHaveTheFusedMapOfFuseMaps) {
  const std::map<std::string, Map> maps = {
      {"r1", part(0, 70, 0)}, {"r2", part(20, 85, 40)}, {"r3", part(45, 99, -70)}};
  SimulatedNetwork network(1, {0.5, 2});
  std::vector<std::unique_ptr<Robot>> robots;
  for (const char* name : {"r3", "r1", "r2"}) {  // r1 gives the frame, but is not the first
    robots.push_back(std::make_unique<Robot>(network, name));
    robots.back()->exchange.publish(maps.at(name));
    for (int i = 0; i < 6; i++) {
      for (const auto& robot : robots) robot->step();
      network.step();
    }
  }
  for (int i = 0; i < 60; i++) {
    for (const auto& robot : robots) robot->step();
    network.step();
  }
  std::vector<RobotMap> expected;
  for (const auto& [name, map] : maps) expected.push_back({name, PreparedMap(map)});
  const ManyFused fused = fuseMaps(expected, {});
  for (const auto& robot : robots) {
    const TeamKnowledge& known = *robot->knowledge;
    EXPECT_EQ(known.whole_maps, 3U);
    EXPECT_TRUE(known.meetings.empty());
    EXPECT_TRUE(known.notes.empty());
    ASSERT_TRUE(known.state);
    EXPECT_TRUE(map_tests::sameTree(*known.state->map, *fused.map));
    for (size_t k = 0; k < 3; k++) {
      EXPECT_EQ(known.state->members[k].robot, fused.members[k].robot);
      EXPECT_TRUE(known.state->members[k].joined);
    }
  }
}

TEST(TeamView, RobotsMeetByTheOutlineAndWantTheOverlapFirst) {
  const ApartmentPair pair(0.1);
  const Map a = std::make_shared<const octomap::OcTree>(*pair.map_a);
  octomap::OcTree noisy(*pair.map_b);  // so that it needs many blocks
  std::mt19937 random(1);
  for (auto leaf = noisy.begin_leafs(); leaf != noisy.end_leafs(); ++leaf)
    leaf->setLogOdds(leaf->getLogOdds() + static_cast<float>(random() % 1000) / 2000);
  noisy.updateInnerOccupancy();
  const Map b = std::make_shared<const octomap::OcTree>(noisy);
  const SourceName name_a{"a", ""}, name_b{"b", ""};
  MapReplica replica_a(name_a), replica_b(name_b);
  for (const Sample& s : SentMap(replica_a).update(a)) replica_a.add(s);
  for (const Sample& s : SentMap(replica_b).update(b))
    if (s.key.kind != SampleKind::Block) replica_b.add(s);
  TeamView view("a", {});
  const TeamKnowledge known = view.update({MapSnapshot(replica_a), MapSnapshot(replica_b)});
  ASSERT_EQ(known.meetings.size(), 1U);
  const Eigen::Isometry3d error = pair.truth.inverse() * known.meetings[0].T_own_other;
  EXPECT_LT(error.translation().norm(), 0.3);
  EXPECT_GT(known.meetings[0].probability, 0.85);

  ASSERT_EQ(known.wanted.size(), 1U);
  const auto& wanted = known.wanted[0].blocks;
  ASSERT_FALSE(wanted.empty());
  EXPECT_LT(wanted.size(), replica_b.index()->blocks.size());
  size_t in_a = 0, in_total = 0;  // obstacles of the first block that A knows
  MapReplica whole(name_b);
  for (const Sample& s : SentMap(whole).update(b)) whole.add(s);
  const MapBlocks blocks = *whole.blocks();
  const auto first = joinBlocks({blocks.trunk, {*blocks.blocks.find(wanted.front())}});
  for (auto leaf = first->begin_leafs(); leaf != first->end_leafs(); ++leaf) {
    if (!first->isNodeOccupied(*leaf)) continue;
    const octomap::point3d p = leaf.getCoordinate();
    const Eigen::Vector3d q = pair.truth * Eigen::Vector3d(p.x(), p.y(), p.z());
    in_total++;
    if (a->search(q.x(), q.y(), q.z())) in_a++;
  }
  EXPECT_GT(in_a, in_total / 2);
}

TEST(TeamView, APartOfAMapJoinsAndAnOlderWholeMapStaysUntilTheNewerIsWhole) {
  const Map a = part(0, 70, 0), b1 = part(20, 85, 40), b2 = part(15, 90, 40);
  const SourceName name_a{"a", ""}, name_b{"b", ""};
  MapReplica replica_a(name_a), replica_b(name_b);
  for (const Sample& s : SentMap(replica_a).update(a)) replica_a.add(s);
  SentMap sent(replica_b);
  TeamView view("a", {});
  const auto look = [&] { return view.update({MapSnapshot(replica_a), MapSnapshot(replica_b)}); };
  EXPECT_EQ(look().state->members.size(), 1U);
  for (const Sample& s : sent.update(b1)) replica_b.add(s);
  const auto first = look().state;
  ASSERT_EQ(first->members.size(), 2U);
  EXPECT_TRUE(first->members[1].joined);
  const auto second = sent.update(b2);
  replica_b.add(second.front());  // the index alone: the map is no longer complete
  EXPECT_EQ(replica_b.completeVersion(), 0U);
  EXPECT_EQ(look().state, first);
  for (const Sample& s : second) replica_b.add(s);
  const auto known = look();
  EXPECT_NE(known.state, first);
  EXPECT_EQ(known.whole_maps, 2U);
  const ManyFused fused = fuseMaps({{"a", PreparedMap(a)}, {"b", PreparedMap(b2)}}, {});
  EXPECT_TRUE(map_tests::sameTree(*known.state->map, *fused.map));
}

TEST(TeamView, ADamagedOutlineIsNoted) {
  const Map a = part(0, 70, 0), b = part(20, 85, 40);
  const SourceName name_a{"a", ""}, name_b{"b", ""};
  MapReplica replica_a(name_a), replica_b(name_b);
  for (const Sample& s : SentMap(replica_a).update(a)) replica_a.add(s);
  for (const Sample& s : SentMap(replica_b).update(b)) replica_b.add(s);
  MapSnapshot part_of_b(replica_b);
  part_of_b.complete_version = 0;  // it joins by its blocks, and its outline orders the others
  part_of_b.outline = "no outline";
  TeamView view("a", {});
  const auto known = view.update({MapSnapshot(replica_a), part_of_b});
  ASSERT_EQ(known.state->members.size(), 2U);
  EXPECT_TRUE(known.state->members[1].joined);
  EXPECT_FALSE(known.notes.empty());
  ASSERT_EQ(known.wanted.size(), 1U);
  EXPECT_TRUE(known.wanted[0].blocks.empty());
  EXPECT_FALSE(known.wanted[0].no_others);
}

TEST(TeamView, MapsWithTooManyNodesAreNotedAndLeftOut) {
  // Voxels that are all alike, but not pruned: 73k nodes in few bytes, at 300 places.
  octomap::OcTree alike(kVoxel);
  const auto key = [](int i) { return static_cast<octomap::key_type>(32768 + i); };
  for (int i = 0; i < 40 * 40 * 40; i++)
    alike.setNodeValue(octomap::OcTreeKey(key(i % 40), key(i / 40 % 40), key(i / 1600)), 1.F, true);
  alike.updateInnerOccupancy();
  const auto* node =
      alike.search(octomap::OcTreeKey(key(0), key(0), key(0)), 10);  // a cube of 64^3 voxels
  const auto bytes =
      std::make_shared<const std::string>(compressNodes(*node, 10, Packing::Smallest));
  MapReplica nothing({"a", ""});
  MapSnapshot bomb(nothing);
  bomb.complete_version = 1;
  bomb.blocks = MapBlocks{divideIntoBlocks(alike).trunk, {}};
  for (unsigned i = 0; i < 300; i++) {
    OcTreeCube place;
    place.depth = 10;
    place.key[0] = static_cast<octomap::key_type>(i % 20 * place.side());
    place.key[1] = static_cast<octomap::key_type>(i / 20 * place.side());
    bomb.blocks->blocks[codeOf(place)] = bytes;
  }
  TeamView view("a", {});
  const auto known = view.update({bomb});
  EXPECT_EQ(known.whole_maps, 0U);
  EXPECT_EQ(known.notes.size(), 1U);
}

TEST(TeamView, AMapThatCannotBeUsedIsNotedAndLeftOut) {
  const Map a = part(0, 70, 0);
  const SourceName name_a{"a", ""}, name_b{"b", ""};
  MapReplica replica_a(name_a), replica_b(name_b);
  for (const Sample& s : SentMap(replica_a).update(a)) replica_a.add(s);
  auto free_space = std::make_shared<octomap::OcTree>(kVoxel);
  map_tests::putVoxel(*free_space, {1, 2, 3}, -1.F);
  map_tests::finish(*free_space);
  for (const Sample& s : SentMap(replica_b).update(free_space)) replica_b.add(s);
  MapSnapshot broken(replica_b);
  broken.source.robot = "c";
  broken.blocks->blocks.begin()->second = std::make_shared<const std::string>("no block");
  TeamView view("a", {});
  const auto known = view.update({MapSnapshot(replica_a), MapSnapshot(replica_b), broken});
  ASSERT_TRUE(known.state);
  EXPECT_EQ(known.state->members.size(), 1U);
  ASSERT_EQ(known.notes.size(), 1U);
  EXPECT_EQ(known.notes[0].rfind("c: ", 0), 0U) << known.notes[0];
}

}  // namespace
}  // namespace mrpt::fusion::test::team_view_test
