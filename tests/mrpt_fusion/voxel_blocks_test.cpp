// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/fusion/voxel_blocks.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <vector>

namespace mrpt::fusion::test {
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

/** The brute-force twin. */
Neighbours neighboursOf(const std::vector<octomap::OcTreeKey>& keys, uint32_t i, double radius) {
  Neighbours found;
  for (uint32_t j = 0; j < keys.size(); j++) {
    const VoxelBlocks::Offset o{keys[j][0] - keys[i][0], keys[j][1] - keys[i][1],
                                keys[j][2] - keys[i][2]};
    const double squared = 1.0 * o[0] * o[0] + 1.0 * o[1] * o[1] + 1.0 * o[2] * o[2];
    if (squared <= radius * radius) found[j] = o;
  }
  return found;
}

void expectSameAsTwin(const std::vector<octomap::OcTreeKey>& keys, double radius) {
  const VoxelBlocks blocks(keys);
  const VoxelBlocks::Ball ball(radius);
  std::vector<int> visits(keys.size());
  for (size_t b = 0; b < blocks.size(); b++)
    blocks.forEachVoxel(b, ball, [&](uint32_t i, const auto& neighbours) {
      visits.at(i)++;
      Neighbours found;
      neighbours([&](uint32_t j, const VoxelBlocks::Offset& o) {
        EXPECT_TRUE(found.emplace(j, o).second) << "met twice";
      });
      ASSERT_EQ(found, neighboursOf(keys, i, radius)) << i << " at radius " << radius;
    });
  for (size_t i = 0; i < keys.size(); i++) EXPECT_EQ(visits[i], 1) << i;
}

TEST(VoxelBlocks, MeetEachVoxelOnceWithAllItsNeighboursAmongDenseVoxels) {
  std::mt19937 random(1);
  const auto keys = randomKeys(600, 32760, 32773, random);  // across block and octant borders
  for (const double radius : {0.0, 0.9, 1.0, 1.5, 2.5, 3.9, 4.0, 4.1, 6.0, 7.3, 8.0, 13.5})
    expectSameAsTwin(keys, radius);
}

TEST(VoxelBlocks, MeetEachVoxelOnceWithAllItsNeighboursAmongScatteredVoxels) {
  std::mt19937 random(2);
  const auto keys = randomKeys(800, 0, 300, random);  // nearly every voxel a block of its own
  for (const double radius : {1.0, 6.0, 12.0}) expectSameAsTwin(keys, radius);
}

TEST(VoxelBlocks, DoNotWrapAroundAtTheEndsOfTheKeyRange) {
  expectSameAsTwin({{0, 0, 0}, {65535, 65535, 65535}, {0, 65535, 7}, {65535, 0, 7}, {1, 1, 1}}, 6);
}

TEST(VoxelBlocks, OrderOfNeighboursDependsOnTheKeysAlone) {
  std::mt19937 random(3);
  auto keys = randomKeys(200, 32760, 32773, random);
  const auto walk = [&] {
    const VoxelBlocks blocks(keys);
    const VoxelBlocks::Ball ball(3);
    std::vector<std::array<int, 6>> order;
    for (size_t b = 0; b < blocks.size(); b++)
      blocks.forEachVoxel(b, ball, [&](uint32_t i, const auto& neighbours) {
        neighbours([&](uint32_t j, const VoxelBlocks::Offset&) {
          order.push_back({keys[i][0], keys[i][1], keys[i][2], keys[j][0], keys[j][1], keys[j][2]});
        });
      });
    return order;
  };
  const auto before = walk();
  std::shuffle(keys.begin(), keys.end(), random);
  EXPECT_EQ(walk(), before);
}

TEST(VoxelBlocks, OfNoVoxelsAreNone) { EXPECT_EQ(VoxelBlocks({}).size(), 0); }

}  // namespace
}  // namespace mrpt::fusion::test
