// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>

#include <array>

#include "fusion_octree/files.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::colours_test {
namespace {

using mrpt::maps::CColouredOctoMap;
using mrpt::maps::CProbOctoMap;
using mrpt::poses::CPose3D;
using Colour = std::array<int, 3>;

const Colour kUnset = {255, 255, 255}, kBrick = {180, 60, 40}, kPaint = {20, 90, 200};

/** A map in which every obstacle has one colour. */
std::shared_ptr<CColouredOctoMap> painted(const CProbOctoMap& map, const Colour& c) {
  auto coloured = map.toColouredOctoMap();
  coloured->setVoxelColourMethod(CColouredOctoMap::SET);
  for (const auto& p : extractOccupiedVoxels(map.octree()).centre)
    coloured->updateVoxelColour(p.x(), p.y(), p.z(), static_cast<uint8_t>(c[0]),
                                static_cast<uint8_t>(c[1]), static_cast<uint8_t>(c[2]));
  return coloured;
}

Colour colourAt(const CColouredOctoMap& map, const Eigen::Vector3f& p) {
  uint8_t r = 0, g = 0, b = 0;
  EXPECT_TRUE(map.getPointColour(p.x(), p.y(), p.z(), r, g, b));
  return {r, g, b};
}

TEST(Colours, OfTwoMapsSurviveTheirFusion) {
  // Two robots' parts of an apartment, some of it in both; B lies turned in A.
  const CProbOctoMap a(apartment({0, 0, 0}, {59, 69, 25})), b(apartment({30, 0, 0}, {99, 69, 25}));
  const auto coloured_a = painted(a, kBrick), coloured_b = painted(b, kPaint);
  const CPose3D pose(0.52, -0.31, 0.04, 0.5, 0.02, 0);
  const mrpt::slam::CProbabilisticMapMatching pmm;
  const CProbOctoMap fused = pmm.merge(*coloured_a, *coloured_b, pose);
  const auto result = fused.toColouredOctoMap({{*coloured_a, CPose3D()}, {*coloured_b, pose}});

  EXPECT_TRUE(mrpt::fusion::serializeNodes(fused.octree()) ==
              mrpt::fusion::serializeNodes(CProbOctoMap(*result).octree()));
  size_t brick = 0, paint = 0, mixed = 0;
  for (const auto& p : extractOccupiedVoxels(fused.octree()).centre) {
    const Colour c = colourAt(*result, p);
    ASSERT_NE(kUnset, c) << "an obstacle without a colour";
    if (c == kBrick)
      brick++;
    else if (c == kPaint)
      paint++;
    else
      mixed++;  // both have one here, or a pruned leaf has voxels of either
    for (size_t i = 0; i < 3; i++) {
      EXPECT_GE(c[i], std::min(kBrick[i], kPaint[i]));
      EXPECT_LE(c[i], std::max(kBrick[i], kPaint[i]));
    }
  }
  EXPECT_GT(brick, 1000U);
  EXPECT_GT(paint, 1000U);
  EXPECT_GT(mixed, 100U);
  // Where only one of the robots was, the colour is that robot's.
  size_t only_b = 0;
  const auto inA = [&](const Eigen::Vector3f& p) {
    return a.octree().search(p.x(), p.y(), p.z()) != nullptr;
  };
  for (const auto& p : extractOccupiedVoxels(b.octree()).centre) {
    const auto q = pose.composePoint(mrpt::math::TPoint3D(p.x(), p.y(), p.z()));
    const Eigen::Vector3f at(static_cast<float>(q.x), static_cast<float>(q.y),
                             static_cast<float>(q.z));
    const auto* node = fused.octree().search(at.x(), at.y(), at.z());
    if (at.x() > 7 && !inA(at) && node && fused.octree().isNodeOccupied(node)) {
      EXPECT_EQ(kPaint, colourAt(*result, at));
      only_b++;
    }
  }
  EXPECT_GT(only_b, 100U);
}

}  // namespace
}  // namespace mrpt::fusion::test::colours_test
