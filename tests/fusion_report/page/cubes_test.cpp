// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the cubes of a picture. */

#include "fusion_report/page/cubes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "fusion_report/page/base64.h"
#include "support/tree_tools.h"

using namespace mrpt::fusion;
using namespace map_tests;

namespace {

/** Reads packed cubes as the page does. */
class Unpacked {
 public:
  explicit Unpacked(const PackedCubes& cubes) : cubes_(cubes) {
    if (!cubes.tree.empty()) node({});
    EXPECT_EQ(read_, cubes.tree.size());
    EXPECT_EQ(result.size(), cubes.values.size());
  }
  std::vector<PageCube> result;

 private:
  void node(const OcTreeCube& cube) {
    const unsigned low = static_cast<unsigned char>(cubes_.tree.at(read_)),
                   high = static_cast<unsigned char>(cubes_.tree.at(read_ + 1));
    read_ += 2;
    for (unsigned i = 0; i < 8; i++) {
      const unsigned kind = (low | high << 8U) >> (2 * i) & 3U;
      if (kind == 1)
        result.push_back({cube.child(i), static_cast<uint8_t>(cubes_.values.at(result.size()))});
      if (kind == 2) node(cube.child(i));
    }
  }
  const PackedCubes& cubes_;
  size_t read_ = 0;
};

testing::AssertionResult sameCubes(const std::vector<PageCube>& a, const std::vector<PageCube>& b) {
  if (a.size() != b.size()) return testing::AssertionFailure() << a.size() << " and " << b.size();
  for (size_t i = 0; i < a.size(); i++)
    if (!(a[i].cube.key == b[i].cube.key) || a[i].cube.depth != b[i].cube.depth ||
        a[i].value != b[i].value)
      return testing::AssertionFailure() << "cube " << i << " differs";
  return testing::AssertionSuccess();
}

VoxelIndex indexOf(const OcTreeCube& cube) {
  return {cube.key[0] - kOriginKey, cube.key[1] - kOriginKey, cube.key[2] - kOriginKey};
}

/** Calls f for each finest voxel of a cube. */
template <class F>
void forEachVoxelOf(const OcTreeCube& cube, F&& f) {
  const int side = static_cast<int>(cube.side());
  for (int x = 0; x < side; x++)
    for (int y = 0; y < side; y++)
      for (int z = 0; z < side; z++) {
        const VoxelIndex low = indexOf(cube);
        f(VoxelIndex{low[0] + x, low[1] + y, low[2] + z});
      }
}

TEST(Base64, IsThatOfTheStandard) {  // RFC 4648, section 10
  const std::map<std::string, std::string> texts = {{"", ""},
                                                    {"f", "Zg=="},
                                                    {"fo", "Zm8="},
                                                    {"foo", "Zm9v"},
                                                    {"foob", "Zm9vYg=="},
                                                    {"fooba", "Zm9vYmE="},
                                                    {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : texts) EXPECT_EQ(toBase64(bytes), text);
  EXPECT_EQ(toBase64(std::string("\xff\x00\xfe", 3)), "/wD+");
}

TEST(PageCubes, HaveTheLogOddsOfTheOccupiedLeaves) {
  const auto tree = sceneTree(0.1, 1);
  std::map<VoxelIndex, float> occupied;
  for (const auto& [at, log_odds] : voxelsOf(*tree))
    if (log_odds >= tree->getOccupancyThresLog()) occupied[at] = log_odds;
  const PageCubes cubes = occupiedCubes(*tree);
  EXPECT_EQ(cubes.resolution, 0.1);
  std::map<VoxelIndex, float> drawn;
  for (const PageCube& c : cubes.cubes)
    forEachVoxelOf(c.cube, [&](const VoxelIndex& at) { drawn[at] = (c.value - 128) / 16.0F; });
  ASSERT_EQ(drawn.size(), occupied.size());
  for (const auto& [at, log_odds] : occupied) EXPECT_NEAR(drawn.at(at), log_odds, 1.0 / 32 + 1e-6);
}

TEST(PageCubes, TakeAnyLogOdds) {
  EXPECT_EQ(valueOf(0), 128);
  EXPECT_EQ(valueOf(1e30F), 255);
  EXPECT_EQ(valueOf(-1e30F), 0);
  EXPECT_EQ(valueOf(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_EQ(valueOf(std::numeric_limits<float>::infinity()), 255);
}

TEST(PageCubes, AreUnpackedAsTheyWerePacked) {
  for (const auto& tree : {sceneTree(0.1, 2), awkwardTree(0.05), smallTree()}) {
    const PageCubes cubes = occupiedCubes(*tree);
    ASSERT_FALSE(cubes.cubes.empty());
    EXPECT_TRUE(sameCubes(Unpacked(packed(cubes)).result, cubes.cubes));
  }
  EXPECT_TRUE(packed({0.1, {}}).tree.empty());
}

TEST(PageCubes, TakeALeafOfTheWholeGrid) {
  const PackedCubes bytes = packed({0.1, {{OcTreeCube{}, 200}}});
  const auto cubes = Unpacked(bytes).result;
  ASSERT_EQ(cubes.size(), 8U);
  for (const PageCube& c : cubes) {
    EXPECT_EQ(c.cube.depth, 1U);
    EXPECT_EQ(c.value, 200);
  }
}

TEST(PageCubes, AreSmallAsBytes) {
  octomap::OcTree tree(0.1);
  for (int x = 0; x < 100; x++)
    for (int y = 0; y < 100; y++) putVoxel(tree, {x, y, 5}, 0.01F * static_cast<float>(x + y));
  const PackedCubes bytes = packed(occupiedCubes(tree));
  EXPECT_EQ(bytes.values.size(), 10'000U);
  EXPECT_LT(bytes.tree.size(),
            0.8 * 10'000);  // a plane has 2 bytes for each 4 cubes, and inner nodes
}

TEST(PageCubes, BecomeCoarserUntilTheyAreFew) {
  const auto tree = sceneTree(0.1, 3);
  const PageCubes all = occupiedCubes(*tree);
  for (const size_t most :
       {all.cubes.size(), all.cubes.size() - 1, size_t{500}, size_t{60}, size_t{8}}) {
    const PageCubes few = coarsened(all, most);
    EXPECT_LE(few.cubes.size(), most);
    EXPECT_TRUE(sameCubes(Unpacked(packed(few)).result, few.cubes)) << most;
    // Each cube lies in a cube that is no less probable.
    for (const PageCube& c : all.cubes) {
      const auto in = std::find_if(few.cubes.begin(), few.cubes.end(),
                                   [&](const PageCube& f) { return f.cube.contains(c.cube); });
      ASSERT_NE(in, few.cubes.end());
      EXPECT_GE(in->value, c.value);
    }
  }
  EXPECT_TRUE(sameCubes(coarsened(all, all.cubes.size()).cubes, all.cubes));
}

TEST(BoundaryOfFreeSpace, IsWhereFreeVoxelsMeetTheUnknown) {
  const auto tree = sceneTree(0.1, 4);
  const auto voxels = voxelsOf(*tree);
  // The faces of all finest voxels, one by one.
  const auto faceOf = [](VoxelIndex at, unsigned face) {
    at[face / 2] += face % 2 ? 1 : -1;
    return at;
  };
  std::map<VoxelIndex, uint8_t> of_leaf;
  for (const NodeRecord& leaf : leavesOf(*tree)) {
    const OcTreeCube cube{{static_cast<uint16_t>(leaf.key[0]), static_cast<uint16_t>(leaf.key[1]),
                           static_cast<uint16_t>(leaf.key[2])},
                          leaf.depth};
    uint8_t mask = 0;
    const int side = static_cast<int>(cube.side());
    const int low = ~(side - 1);
    OcTreeCube lowest = cube;
    for (unsigned axis = 0; axis < 3; axis++)
      lowest.key[axis] = static_cast<uint16_t>(lowest.key[axis] & low);
    bool is_free = false;
    forEachVoxelOf(lowest, [&](const VoxelIndex& at) {
      is_free = voxels.at(at) < tree->getOccupancyThresLog();
      for (unsigned face = 0; face < 6; face++) {
        const VoxelIndex beside = faceOf(at, face);
        if (!voxels.count(beside)) mask = static_cast<uint8_t>(mask | 1U << face);
      }
    });
    if (is_free && mask) of_leaf[indexOf(lowest)] = mask;
  }
  const PageCubes boundary = boundaryOfFreeSpace(*tree);
  ASSERT_GT(boundary.cubes.size(), 50U);
  EXPECT_EQ(boundary.cubes.size(), of_leaf.size());
  for (const PageCube& c : boundary.cubes)
    EXPECT_EQ(c.value, of_leaf[indexOf(c.cube)]) << c.cube.depth;
}

TEST(BoundaryOfFreeSpace, EndsAtTheEndOfTheGrid) {
  octomap::OcTree tree(0.1);
  putLeaf(tree, {-kOriginKey, 0, 0}, 3, -1);
  const PageCubes boundary = boundaryOfFreeSpace(tree);
  ASSERT_EQ(boundary.cubes.size(), 1U);
  EXPECT_EQ(boundary.cubes[0].value, 0x3f);
}

}  // namespace
