// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of what a robot has of a map: samples in any order, twice, from hostile robots. */
#include "fusion_link/map_replica.h"

#include <gtest/gtest.h>

#include <random>

#include "fusion_link/outline.h"
#include "fusion_link/sent_map.h"
#include "support/tree_tools.h"

using namespace map_tests;

namespace mrpt::fusion::test::map_replica_test {
namespace {

const SourceName kSource{"r1", ""};
constexpr uint64_t kFirst = uint64_t{1} << 16U;  ///< First version of a robot in its run 0

using Map = std::shared_ptr<const octomap::OcTree>;

/** A map that grows: version \a n has n rooms full of clutter. */
Map growing(int n) {
  auto tree = std::make_shared<octomap::OcTree>(0.1);
  std::mt19937 random(5);
  for (int room = 0; room < n; room++)
    for (int i = 0; i < 6000; i++)
      putVoxel(*tree,
               {static_cast<int>(random() % 30) + 40 * room, static_cast<int>(random() % 30),
                static_cast<int>(random() % 20)},
               static_cast<float>(random() % 1000) / 300 - 1);
  finish(*tree);
  return tree;
}

/** Returns whether adding a sample is refused with a message. */
bool refuses(MapReplica& replica, const Sample& sample) {
  try {
    replica.add(sample);
  } catch (const std::runtime_error&) {
    return true;
  }
  return false;
}

size_t blocksIn(const std::vector<Sample>& samples) {
  return static_cast<size_t>(std::count_if(samples.begin(), samples.end(), [](const Sample& s) {
    return s.key.kind == SampleKind::Block;
  }));
}

TEST(MapReplica, IsCompleteWhenAllSamplesHaveArrivedInAnyOrderAndTwice) {
  const Map map = growing(4);
  std::vector<Sample> samples = SentMap(MapReplica(kSource)).update(map);
  ASSERT_GT(blocksIn(samples), 8U);
  std::mt19937 random(1);
  for (int round = 0; round < 5; round++) {
    std::shuffle(samples.begin(), samples.end(), random);
    MapReplica replica(kSource);
    for (size_t i = 0; i < samples.size(); i++) {
      EXPECT_EQ(replica.completeVersion(), 0U);
      EXPECT_TRUE(replica.add(samples[i]));
      EXPECT_FALSE(replica.add(samples[i]));
      EXPECT_FALSE(replica.add(samples[i / 2]));
    }
    EXPECT_EQ(replica.completeVersion(), 1 * kFirst);
    EXPECT_TRUE(replica.missing().empty());
    EXPECT_TRUE(sameTree(*map, *joinBlocks(*replica.blocks())));
  }
}

TEST(MapReplica, TheLatestVersionWinsInAnyOrder) {
  SentMap sent{MapReplica(kSource)};
  std::vector<Sample> samples;
  for (int version = 1; version <= 4; version++)
    for (const Sample& s : sent.update(growing(version))) samples.push_back(s);
  std::mt19937 random(2);
  for (int round = 0; round < 5; round++) {
    std::shuffle(samples.begin(), samples.end(), random);
    MapReplica replica(kSource);
    for (const Sample& s : samples) replica.add(s);
    EXPECT_EQ(replica.completeVersion(), 4 * kFirst);
    EXPECT_TRUE(sameTree(*growing(4), *joinBlocks(*replica.blocks())));
  }
}

TEST(MapReplica, SamplesOfOneVersionWithOtherBytesHaveOneOrder) {
  const auto one = SentMap(MapReplica(kSource)).update(growing(1));
  const auto other = SentMap(MapReplica(kSource)).update(growing(2));
  MapReplica a(kSource), b(kSource);
  for (const auto* samples : {&one, &other})
    for (const Sample& s : *samples) a.add(s);
  for (const auto* samples : {&other, &one})
    for (const Sample& s : *samples) b.add(s);
  const auto keysAndBytes = [](const MapReplica& replica) {
    std::map<SampleKey, std::string> result;
    for (const Sample& s : replica.samples()) result[s.key] = s.bytes;
    return result;
  };
  EXPECT_EQ(keysAndBytes(a), keysAndBytes(b));
}

TEST(MapReplica, RestoresItselfFromItsSamples) {
  MapReplica replica(kSource), restored(kSource);
  for (const Sample& s : SentMap(replica).update(growing(2))) replica.add(s);
  for (const Sample& s : replica.samples()) restored.add(s);
  EXPECT_EQ(restored.completeVersion(), 1 * kFirst);
  EXPECT_EQ(restored.bytes(), replica.bytes());
  EXPECT_EQ(restored.outline(), replica.outline());
}

TEST(MapReplica, ForgetsBlocksThatTheMapNoLongerHas) {
  MapReplica replica(kSource);
  SentMap sent(replica);
  for (const Sample& s : sent.update(growing(4))) replica.add(s);
  const size_t bytes = replica.bytes();
  for (const Sample& s : sent.update(growing(1))) replica.add(s);
  EXPECT_EQ(replica.completeVersion(), 2 * kFirst);
  EXPECT_LT(replica.bytes(), bytes / 2);
  EXPECT_FALSE(sent.takeObsolete().empty());
  EXPECT_TRUE(sent.takeObsolete().empty());
}

TEST(MapReplica, LooksAtAMapThatComesAtOnceWhenAllOfItIsThere) {
  const auto samples = SentMap(MapReplica(kSource)).update(growing(1));
  MapReplica whole(kSource), at_once(kSource), one_by_one(kSource);
  for (const Sample& s : samples) whole.add(s);
  auto with_surplus = samples;  // followed by blocks that the index does not name
  for (const Sample& s : SentMap(MapReplica(kSource)).update(growing(4)))
    if (s.key.kind == SampleKind::Block && whole.versionOf(s.key.number) == 0)
      with_surplus.push_back(s);
  ASSERT_GT(with_surplus.size(), samples.size());
  at_once.add(with_surplus);
  for (const Sample& s : with_surplus) one_by_one.add(s);
  EXPECT_EQ(at_once.completeVersion(), 1 * kFirst);
  EXPECT_EQ(one_by_one.completeVersion(), 1 * kFirst);
  EXPECT_EQ(at_once.bytes(), whole.bytes());
  EXPECT_GT(one_by_one.bytes(), whole.bytes());
}

TEST(MapReplica, ADamagedSampleOfManyLeavesTheSamplesBeforeIt) {
  auto samples = SentMap(MapReplica(kSource)).update(growing(1));
  samples[samples.size() / 2].bytes.assign(9000, 'x');
  MapReplica replica(kSource);
  EXPECT_THROW(replica.add(samples), std::runtime_error);
  EXPECT_EQ(replica.samples().size(), samples.size() / 2);
}

TEST(MapReplica, RefusesDamagedSamplesAndStaysAsItWas) {
  MapReplica replica(kSource);
  const auto samples = SentMap(replica).update(growing(2));
  for (const Sample& s : samples) replica.add(s);
  std::mt19937 random(3);
  for (int i = 0; i < 2000; i++) {
    Sample s = samples[random() % samples.size()];
    s.version = random() % 2 ? 5 * kFirst : std::numeric_limits<uint64_t>::max() - random() % 3;
    switch (random() % 4) {
      case 0:
        s.bytes.resize(random() % (s.bytes.size() + 1));
        break;
      case 1:
        s.bytes[random() % s.bytes.size()] ^= static_cast<char>(1 + random() % 255);
        break;
      case 2:
        s.key.number = random();
        break;
      default:
        s.bytes.assign(9000, 'x');
    }
    try {
      replica.add(s);  // what is not damaged, such as a block at another place, is accepted
    } catch (const std::runtime_error&) {
    }
  }
  Sample late = samples[0];
  late.version = kMostVersion + 1;
  EXPECT_TRUE(refuses(replica, late));
  late.version = 0;
  EXPECT_TRUE(refuses(replica, late));
  EXPECT_NO_THROW(joinBlocks(*replica.blocks()));
}

TEST(MapReplica, ADamagedIndexDoesNotReplaceTheIndex) {
  MapReplica replica(kSource);
  SentMap sent(replica);
  for (const Sample& s : sent.update(growing(1))) replica.add(s);
  auto next = sent.update(growing(2));
  ASSERT_EQ(next[0].key.kind, SampleKind::Index);
  Sample damaged = next[0];
  damaged.version += kFirst;  // newer than the right index
  EXPECT_TRUE(refuses(replica, damaged));
  damaged.bytes.resize(damaged.bytes.size() - 9);
  EXPECT_TRUE(refuses(replica, damaged));
  for (const Sample& s : next) replica.add(s);
  EXPECT_EQ(replica.completeVersion(), 2 * kFirst);
}

TEST(MapReplica, ManyKeysTakeNoMoreThanTheLimit) {
  constexpr size_t kMost = 200'000;
  MapReplica replica(kSource, kMost);
  const std::string bytes = *divideIntoBlocks(*smallTree()).blocks.begin()->second;
  size_t refused = 0;
  for (uint64_t i = 0; i < 20'000; i++)
    refused += refuses(replica, {{kSource, SampleKind::Block, (uint64_t{1} << 24U) + i}, 1, bytes});
  EXPECT_GT(refused, 15'000U);
  EXPECT_LE(replica.bytes(), kMost);
}

TEST(SentMap, SendsNothingIfNothingChanged) {
  SentMap sent{MapReplica(kSource)};
  EXPECT_FALSE(sent.update(growing(2)).empty());
  EXPECT_TRUE(sent.update(growing(2)).empty());
  EXPECT_EQ(sent.version(), kFirst);
}

TEST(SentMap, SendsTheBlocksThatChanged) {
  SentMap sent{MapReplica(kSource)};
  const size_t all = blocksIn(sent.update(growing(6)));
  auto map = std::make_shared<octomap::OcTree>(*growing(6));
  putVoxel(*map, {3, 3, 3}, 3.4F);
  finish(*map);
  const auto samples = sent.update(map);
  EXPECT_LE(blocksIn(samples), 2U);
  EXPECT_LE(samples.size(), 3U);  // the index, no outline
  EXPECT_GT(all, 10U);
}

TEST(SentMap, ContinuesAfterARestart) {
  MapReplica own(kSource);
  for (const Sample& s : SentMap(own).update(growing(2))) own.add(s);
  SentMap restarted(own);
  EXPECT_EQ(restarted.version(), kFirst);
  EXPECT_TRUE(restarted.update(growing(2)).empty());
  for (const Sample& s : restarted.update(growing(3))) own.add(s);
  EXPECT_EQ(own.completeVersion(), 2 * kFirst);
}

TEST(SentMap, WithoutMemoryContinuesAboveTheVersionsOfOthers) {
  MapReplica others(kSource);
  SentMap sent(others);
  for (int n = 1; n < 4; n++)
    for (const Sample& s : sent.update(growing(n))) others.add(s);
  ASSERT_EQ(others.completeVersion(), 3 * kFirst);
  SentMap restarted{MapReplica(kSource)};
  for (const Sample& s : restarted.update(growing(2))) others.add(s);
  EXPECT_EQ(others.completeVersion(), 3 * kFirst);  // version 1 is old
  for (const Sample& s : restarted.continueAbove(others.highestVersion())) others.add(s);
  EXPECT_EQ(others.completeVersion(), 4 * kFirst);
  EXPECT_TRUE(sameTree(*growing(2), *joinBlocks(*others.blocks())));
  EXPECT_THROW(restarted.continueAbove(kMostVersion), std::runtime_error);
}

TEST(MapIndex, KeepsAllFieldsAndRefusesOthers) {
  const auto map = sceneTree(0.1, 3);
  map->getRoot()->setLogOdds(0.123F);
  const MapBlocks blocks = divideIntoBlocks(*map);
  MapIndex index{7, blocks.trunk, {}, hashOf(blocks.blocks)};
  for (const auto& block : blocks.blocks) index.blocks[block.first] = 1 + block.first % 7;
  const MapIndex again = indexOf(toBytes(index));
  EXPECT_EQ(again.version, 7U);
  EXPECT_EQ(again.hash, index.hash);
  EXPECT_EQ(again.blocks, index.blocks);
  EXPECT_EQ(again.trunk.values, index.trunk.values);
  EXPECT_EQ(again.trunk.resolution, 0.1);

  const auto with = [&](auto change) {
    MapIndex wrong = index;
    change(wrong);
    return toBytes(wrong);
  };
  for (const std::string& bytes :
       {with([](MapIndex& i) { i.version = 0; }), with([](MapIndex& i) { i.version = ~0ULL; }),
        with([](MapIndex& i) { i.blocks.begin()->second = 8; }),
        with([](MapIndex& i) { i.blocks[2] = 1; }),
        with([](MapIndex& i) { i.blocks[i.blocks.begin()->first << 3U] = 1; }),
        with([](MapIndex& i) { i.trunk.resolution = 0; }),
        with([](MapIndex& i) { i.trunk.model.hit = std::nanf(""); })})
    EXPECT_THROW(indexOf(bytes), std::runtime_error);
}

TEST(Outline, KeepsOccupiedAndFreeSpaceInFewBytes) {
  const auto map = growing(6);
  const std::string bytes = outlineOf(*map);
  ASSERT_FALSE(bytes.empty());
  EXPECT_LE(bytes.size(), kMostOutlineBytes);
  const auto outline = outlineFrom(bytes);
  EXPECT_GE(outline->getResolution(), map->getResolution());
  size_t occupied = 0, kept = 0;
  for (auto leaf = map->begin_leafs(); leaf != map->end_leafs(); ++leaf) {
    if (!map->isNodeOccupied(*leaf)) continue;
    occupied++;
    const auto* node = outline->search(leaf.getCoordinate());
    kept += node && outline->isNodeOccupied(node) ? 1 : 0;
  }
  EXPECT_EQ(kept, occupied);
  EXPECT_THROW(outlineFrom(bytes.substr(0, bytes.size() - 3)), std::runtime_error);
  EXPECT_THROW(outlineFrom(""), std::runtime_error);
}

}  // namespace
}  // namespace mrpt::fusion::test::map_replica_test
