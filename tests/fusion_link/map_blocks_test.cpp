// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of octrees as blocks. */
#include "fusion_link/map_blocks.h"

#include <gtest/gtest.h>

#include "fusion_octree/compression.h"
#include "fusion_team/link/link.h"
#include "support/tree_tools.h"

using namespace map_tests;

namespace mrpt::fusion::test::map_blocks_test {
namespace {

/** A map of noise: \a side^3 voxels with a value of their own. */
std::unique_ptr<octomap::OcTree> noise(int side, unsigned seed) {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(-2, 3.5);
  for (int x = 0; x < side; x++)
    for (int y = 0; y < side; y++)
      for (int z = 0; z < side; z++) putVoxel(*tree, {x - 5, y + 3, z}, value(random));
  finish(*tree);
  return tree;
}

TEST(MapBlocks, EachCubeHasANumber) {
  EXPECT_EQ(codeOf({}), 1U);
  std::set<BlockCode> codes;
  for (unsigned depth : {1U, 7U, 16U})
    for (unsigned i = 0; i < 8; i++) {
      OcTreeCube cube;
      for (unsigned d = 0; d < depth; d++) cube = cube.child((i + d) % 8);
      const BlockCode code = codeOf(cube);
      EXPECT_TRUE(codes.insert(code).second);
      ASSERT_TRUE(cubeOf(code));
      EXPECT_EQ(cubeOf(code)->depth, depth);
      EXPECT_EQ(cubeOf(code)->key, cube.key);
    }
  EXPECT_FALSE(cubeOf(0));
  EXPECT_FALSE(cubeOf(2));
  EXPECT_FALSE(cubeOf(uint64_t{1} << 51U));
  EXPECT_FALSE(cubeOf(std::numeric_limits<uint64_t>::max()));
}

TEST(MapBlocks, JoinToTheSameOctreeBitForBit) {
  std::vector<std::unique_ptr<octomap::OcTree>> trees;
  trees.push_back(std::make_unique<octomap::OcTree>(0.25));
  trees.push_back(awkwardTree(1 / 3.));
  trees.push_back(sceneTree(0.1, 7));
  trees.push_back(noise(24, 1));
  trees.push_back(sceneTree(0.1, 3));  // lazily changed: inner nodes are no maxima
  for (int x = 0; x < 50; x++)
    trees.back()->setNodeValue(octomap::OcTreeKey(32768 + x, 32768, 32768), 3.1F, true);
  trees.back()->getRoot()->setLogOdds(0.123F);
  trees.push_back(std::make_unique<octomap::OcTree>(0.1));
  OcTreeAccess::createRoot(*trees.back())->setLogOdds(1.5F);
  trees.push_back(smallTree());
  OcTreeAccess::setSensorModel(*trees.back(), {-1.25F, 4.75F, 0.9F, -0.3F, 0.1F});
  for (const auto& tree : trees) {
    const MapBlocks blocks = divideIntoBlocks(*tree);
    for (const auto& block : blocks.blocks) EXPECT_LE(block.second->size(), kMostSampleBytes);
    const auto joined = joinBlocks(blocks);
    EXPECT_TRUE(sameTree(*tree, *joined));
    EXPECT_EQ(sensorModelBits(*tree), sensorModelBits(*joined));
  }
}

TEST(MapBlocks, NoiseIsDivided) { EXPECT_GT(divideIntoBlocks(*noise(24, 1)).blocks.size(), 5U); }

TEST(MapBlocks, OfSpaceThatDidNotChangeStayTheSame) {
  const auto before = noise(24, 1);
  const MapBlocks blocks_before = divideIntoBlocks(*before);
  octomap::OcTree after(*before);
  putVoxel(after, {10, 15, 20}, 3.4F);
  putVoxel(after, {11, 15, 20}, 3.3F);
  finish(after);
  const MapBlocks blocks = divideIntoBlocks(after, before.get(), blocks_before);
  size_t changed = 0;
  for (const auto& [code, bytes] : blocks.blocks) {
    const auto known = blocks_before.blocks.find(code);
    if (known == blocks_before.blocks.end() || known->second != bytes) changed++;
  }
  EXPECT_GE(changed, 1U);
  EXPECT_LE(changed, 2U);
  EXPECT_TRUE(sameTree(after, *joinBlocks(blocks)));
}

TEST(MapBlocks, AMapThatShrinksToALeafIsOneBlock) {
  const auto before = noise(24, 1);
  const MapBlocks blocks_before = divideIntoBlocks(*before);
  octomap::OcTree after(0.1);
  OcTreeAccess::createRoot(after)->setLogOdds(1.5F);
  const MapBlocks blocks = divideIntoBlocks(after, before.get(), blocks_before);
  EXPECT_EQ(blocks.blocks.size(), 1U);
  EXPECT_TRUE(sameTree(after, *joinBlocks(blocks)));
}

TEST(MapBlocks, EachBlockIsUsefulByItself) {
  const auto map = noise(24, 1);
  const MapBlocks all = divideIntoBlocks(*map);
  const VoxelMap voxels = voxelsOf(*map);
  size_t found = 0;
  for (const auto& block : all.blocks) {
    const VoxelMap part = voxelsOf(*joinBlocks({all.trunk, {block}}));
    for (const auto& voxel : part) EXPECT_EQ(voxels.at(voxel.first), voxel.second);
    found += part.size();
  }
  EXPECT_EQ(found, voxels.size());
}

TEST(MapBlocks, DamagedBlocksAreRefused) {
  const auto map = sceneTree(0.1, 7);
  MapBlocks blocks = divideIntoBlocks(*map);
  const auto [code, bytes] = *blocks.blocks.begin();
  EXPECT_NO_THROW(checkBlock(code, *bytes));
  EXPECT_THROW(checkBlock(code, bytes->substr(0, bytes->size() / 2)), std::runtime_error);
  EXPECT_THROW(checkBlock(code, ""), std::runtime_error);
  EXPECT_THROW(checkBlock(0, *bytes), std::runtime_error);
  EXPECT_THROW(checkBlock(code, compressNodes(octomap::OcTree(0.1))), std::runtime_error);

  blocks.blocks[code << 3U] = bytes;  // a block in a block
  EXPECT_THROW(joinBlocks(blocks), std::runtime_error);
}

TEST(MapBlocks, ABlockOfMillionsOfNodesIsRefused) {
  octomap::OcTree bomb(0.1);  // alike everywhere, so it packs well, but is not pruned
  for (int x = 0; x < 64; x++)
    for (int y = 0; y < 64; y++)
      for (int z = 0; z < 64; z++)
        bomb.setNodeValue(octomap::OcTreeKey(32768 + x, 32768 + y, 32768 + z), 1.F, true);
  bomb.updateInnerOccupancy();
  const std::string bytes = compressNodes(bomb, Packing::Smallest);
  ASSERT_LE(bytes.size(), kMostSampleBytes);
  EXPECT_THROW(checkBlock(1, bytes), std::runtime_error);
  const MapBlocks blocks = divideIntoBlocks(bomb);
  EXPECT_GT(blocks.blocks.size(), 1U);
  EXPECT_TRUE(sameTree(bomb, *joinBlocks(blocks)));
}

}  // namespace
}  // namespace mrpt::fusion::test::map_blocks_test
