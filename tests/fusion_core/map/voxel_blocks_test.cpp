// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/map/voxel_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <vector>

namespace mrpt::fusion::test::voxel_blocks_test {
namespace {

using Place = std::array<int, 3>;
using Neighbours = std::map<uint32_t, VoxelBlocks::Offset>;  // by voxel

/** Different keys drawn from [low, high] along each axis, in no order. */
std::vector<octomap::OcTreeKey> randomKeys(size_t n, int low, int high, std::mt19937& random) {
  std::uniform_int_distribution<int> coordinate(low, high);
  std::set<Place> places;
  while (places.size() < n)
    places.insert({coordinate(random), coordinate(random), coordinate(random)});
  std::vector<octomap::OcTreeKey> keys;
  for (const Place& p : places)
    keys.emplace_back(static_cast<uint16_t>(p[0]), static_cast<uint16_t>(p[1]),
                      static_cast<uint16_t>(p[2]));
  std::shuffle(keys.begin(), keys.end(), random);
  return keys;
}

VoxelBlocks::Place placeOf(const octomap::OcTreeKey& key) { return {key[0], key[1], key[2]}; }

/** The brute-force twin. */
Neighbours neighboursOf(const std::vector<octomap::OcTreeKey>& keys, const Place& at, double radius,
                        double beyond = -1) {
  Neighbours found;
  for (uint32_t j = 0; j < keys.size(); j++) {
    const VoxelBlocks::Offset o{keys[j][0] - at[0], keys[j][1] - at[1], keys[j][2] - at[2]};
    const double squared = 1.0 * o[0] * o[0] + 1.0 * o[1] * o[1] + 1.0 * o[2] * o[2];
    if (squared <= radius * radius && (beyond < 0 || squared > beyond * beyond)) found[j] = o;
  }
  return found;
}

Neighbours found(const VoxelBlocks& blocks, const Place& at, const VoxelBlocks::Ball& ball) {
  Neighbours found;
  blocks.forEachAround(at, ball, [&](uint32_t j, const VoxelBlocks::Offset& o) {
    EXPECT_TRUE(found.emplace(j, o).second) << "met twice";
  });
  return found;
}

void expectSameAsTwin(const std::vector<octomap::OcTreeKey>& keys, double radius) {
  const VoxelBlocks blocks(keys);
  const VoxelBlocks::Ball ball(radius);
  for (const auto& key : keys) {
    const Place at = placeOf(key);
    ASSERT_EQ(found(blocks, at, ball), neighboursOf(keys, at, radius)) << "radius " << radius;
    const Place beside{at[0] + 3, at[1] - 2, at[2] + 1};
    const Neighbours twin = neighboursOf(keys, beside, radius);
    ASSERT_EQ(found(blocks, beside, ball), twin) << "radius " << radius;
    ASSERT_EQ(blocks.anyAround(beside, ball), !twin.empty());
  }
}

TEST(VoxelBlocks, GiveAllNeighboursAmongDenseVoxels) {
  std::mt19937 random(1);
  const auto keys = randomKeys(600, 32760, 32773, random);  // across block and octant borders
  for (const double radius : {0.0, 0.9, 1.0, 1.5, 2.5, 3.9, 4.0, 4.1, 6.0, 7.3, 8.0, 13.5})
    expectSameAsTwin(keys, radius);
}

TEST(VoxelBlocks, GiveAllNeighboursAmongScatteredVoxels) {
  std::mt19937 random(2);
  const auto keys = randomKeys(800, 0, 300, random);  // nearly every voxel a block of its own
  for (const double radius : {1.0, 6.0, 12.0, 40.0}) expectSameAsTwin(keys, radius);
}

TEST(VoxelBlocks, GiveWhatLiesBetweenTwoRadii) {
  std::mt19937 random(4);
  const auto keys = randomKeys(400, 32760, 32773, random);
  const VoxelBlocks blocks(keys);
  for (const auto& [beyond, radius] :
       {std::pair(0.0, 1.5), {1.5, 2.4}, {1.8, 6.0}, {4.0, 4.0}, {3.0, 13.0}}) {
    const VoxelBlocks::Ball shell(radius, beyond);
    for (const auto& key : keys)
      ASSERT_EQ(found(blocks, placeOf(key), shell),
                neighboursOf(keys, placeOf(key), radius, beyond))
          << beyond << " to " << radius;
  }
}

TEST(VoxelBlocks, KnowTheVoxelAtAPlaceWhateverTheirOrder) {
  std::mt19937 random(6);
  auto keys = randomKeys(300, 32760, 32773, random);
  for (const bool in_octree_order : {false, true}) {
    if (in_octree_order)
      std::sort(keys.begin(), keys.end(),
                [](const auto& a, const auto& b) { return octreeOrder(a) < octreeOrder(b); });
    const VoxelBlocks blocks(keys);
    std::map<Place, uint32_t> there;
    for (uint32_t i = 0; i < keys.size(); i++) there[placeOf(keys[i])] = i;
    for (int x = 32755; x < 32780; x++)
      for (int y = 32755; y < 32780; y++)
        for (int z = 32755; z < 32780; z++) {
          const auto twin = there.find({x, y, z});
          const auto found = blocks.at({x, y, z});
          ASSERT_EQ(found.has_value(), twin != there.end());
          if (found) {
            ASSERT_EQ(*found, twin->second);
          }
        }
    expectSameAsTwin(keys, 2.5);
  }
}

TEST(VoxelBlocks, DoNotWrapAroundAtTheEndsOfTheKeyRange) {
  expectSameAsTwin({{0, 0, 0}, {65535, 65535, 65535}, {0, 65535, 7}, {65535, 0, 7}, {1, 1, 1}}, 6);
}

TEST(VoxelBlocks, AWindowShowsWhatIsThere) {
  std::mt19937 random(5);
  const auto keys = randomKeys(500, 32755, 32775, random);
  const VoxelBlocks blocks(keys);
  const std::set<Place> there = [&] {
    std::set<Place> places;
    for (const auto& key : keys) places.insert(placeOf(key));
    return places;
  }();
  constexpr int kReach = 9;
  const VoxelBlocks::Ball ball(2.3);
  VoxelBlocks::Window window(blocks, kReach);
  for (size_t i = 0; i < keys.size(); i += 7) {
    const Place at = placeOf(keys[i]);
    window.moveTo(at);
    for (int z = -kReach; z <= kReach; z += 2)
      for (int y = -kReach; y <= kReach; y++)
        for (int x = -kReach; x <= kReach; x++)
          ASSERT_EQ(window.has({x, y, z}), there.count({at[0] + x, at[1] + y, at[2] + z}) > 0);
    const VoxelBlocks::Offset offset{5, -4, -6};
    std::set<Place> seen, twin;
    window.forEachAround(offset, ball, [&](const VoxelBlocks::Offset& o) { seen.insert(o); });
    const Place beside{at[0] + offset[0], at[1] + offset[1], at[2] + offset[2]};
    for (const auto& [j, o] : neighboursOf(keys, beside, 2.3))
      twin.insert({o[0] + offset[0], o[1] + offset[1], o[2] + offset[2]});
    ASSERT_EQ(seen, twin);
  }
}

TEST(VoxelBlocks, OrderOfNeighboursDependsOnTheKeysAlone) {
  std::mt19937 random(3);
  auto keys = randomKeys(200, 32760, 32773, random);
  const std::vector<octomap::OcTreeKey> places = keys;
  const auto walk = [&] {
    const VoxelBlocks blocks(keys);
    const VoxelBlocks::Ball ball(3);
    std::vector<Place> order;
    for (const auto& place : places)
      blocks.forEachAround(placeOf(place), ball, [&](uint32_t j, const VoxelBlocks::Offset&) {
        order.push_back(placeOf(keys[j]));
      });
    return order;
  };
  const auto before = walk();
  std::shuffle(keys.begin(), keys.end(), random);
  EXPECT_EQ(walk(), before);
}

TEST(VoxelBlocks, SurroundingsMissNoneWithinTheirRadius) {
  std::mt19937 random(8);
  for (const int extent : {9, 60, 65535}) {  // from one piece to the whole key range
    const auto keys = randomKeys(40, 0, extent, random);
    const VoxelBlocks blocks(keys);
    for (const double radius : {1.0, 3.3, 6.9, 20.0}) {
      const VoxelBlocks::Surroundings surroundings(blocks, radius);
      std::uniform_int_distribution<size_t> any(0, keys.size() - 1);
      std::uniform_int_distribution<int> far(-static_cast<int>(radius), static_cast<int>(radius));
      for (int i = 0; i < 500; i++) {
        const octomap::OcTreeKey& key = keys[any(random)];
        const Place at{key[0] + far(random), key[1] + far(random), key[2] + far(random)};
        if (neighboursOf(keys, at, radius).empty()) continue;
        ASSERT_TRUE(surroundings.mayReach(at)) << extent << ", radius " << radius;
      }
      // Beyond all keys, where cubes do not get as large.
      if (extent < 1000) {
        ASSERT_FALSE(surroundings.mayReach({-1000, keys[0][1], keys[0][2]}));
        ASSERT_FALSE(surroundings.mayReach({keys[0][0], 1000, keys[0][2]}));
        ASSERT_FALSE(surroundings.mayReach({keys[0][0], keys[0][1], 100000}));
      }
    }
  }
}

TEST(VoxelBlocks, SurroundingsAreNoWiderThanABlockMore) {
  const std::vector<octomap::OcTreeKey> keys = {{100, 100, 100}, {200, 102, 101}};
  const VoxelBlocks::Surroundings surroundings(VoxelBlocks(keys), 3);
  for (int x = 90; x < 220; x++) {
    const int distance = std::min(std::abs(x - 100), std::abs(x - 200));
    if (distance > 3 && distance <= 10) continue;
    EXPECT_EQ(surroundings.mayReach({x, 100, 100}), distance <= 3) << x;
  }
}

TEST(VoxelBlocks, OfNoVoxelsFindNone) {
  const VoxelBlocks none;
  EXPECT_FALSE(VoxelBlocks::Surroundings().mayReach({0, 0, 0}));
  EXPECT_FALSE(VoxelBlocks::Surroundings(none, 5).mayReach({32768, 32768, 32768}));
  EXPECT_FALSE(none.anyAround({32768, 32768, 32768}, VoxelBlocks::Ball(5)));
}

TEST(OctreeOrder, IsThatOfTheLeaves) {
  std::mt19937 random(6);
  octomap::OcTree tree(0.1);
  for (const auto& key : randomKeys(300, 32700, 32900, random)) tree.updateNode(key, true);
  uint64_t last = 0;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it) {
    EXPECT_GT(octreeOrder(it.getKey()), last);
    last = octreeOrder(it.getKey());
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::voxel_blocks_test
