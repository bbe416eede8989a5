// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the search for the nearest voxel, against a search through all of them. */
#include "fusion_core/map/voxel_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "fusion_core/map/map_voxels.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::voxel_search_test {
namespace {

using Points = std::vector<Eigen::Vector3f>;
using Nearest = VoxelSearch::Nearest;

const auto kNothing = [](uint32_t) { return 0.F; };

/** The twin: of the points of the least distance below the gate the one of lowest index. */
template <class Extra>
Nearest nearestOfAll(const Points& points, const Eigen::Vector3f& p, float squared_gate,
                     const Extra& extra) {
  Nearest best{VoxelSearch::kNone, squared_gate};
  for (uint32_t i = 0; i < points.size(); i++) {
    const float d = (points[i] - p).squaredNorm() + extra(i);
    if (d < best.distance) best = {i, d};
  }
  return best;
}

/** The least squared distance of all points but one. */
float distanceOfOthers(const Points& points, const Eigen::Vector3f& p, uint32_t but) {
  float least = std::numeric_limits<float>::infinity();
  for (uint32_t i = 0; i < points.size(); i++)
    if (i != but) least = std::min(least, (points[i] - p).squaredNorm());
  return least;
}

/** The occupied voxels of a map of 12.8 m with holes, and places in it and around it. */
class NearestVoxel : public testing::Test {
 protected:
  static const OccupiedVoxels& voxels() {
    static const OccupiedVoxels all = extractOccupiedVoxels(*randomTree());
    return all;
  }
  /** Fewer, for the twin looks at all. */
  static Points few() {
    Points points;
    for (size_t i = 0; i < voxels().size(); i += 1 + i % 97) points.push_back(voxels().centre[i]);
    return points;
  }
  static Points queries(size_t n) {
    std::mt19937 random(4);
    std::uniform_real_distribution<float> place(-8, 8);
    Points q;
    for (size_t i = 0; i < n; i++) {
      q.emplace_back(place(random), place(random), place(random));
      if (i % 4 == 0)  // the corner of a voxel: eight are as near
        q.back() = 0.1F * (10 * q.back()).array().round().matrix();
    }
    return q;
  }

  /** Compares all answers with the twin's. \return Number of queries that found a point. */
  template <class Extra>
  static int compareWithTwin(const VoxelSearch& search, const Points& points, double gate,
                             const Extra& extra) {
    int found = 0;
    const auto squared_gate = static_cast<float>(gate * gate);
    for (const Eigen::Vector3f& p : queries(150)) {
      const Nearest expected = nearestOfAll(points, p, squared_gate, extra);
      const Nearest nearest = search.nearest(p, {VoxelSearch::kNone, squared_gate}, extra);
      EXPECT_EQ(nearest.index, expected.index) << p.transpose() << ", gate " << gate;
      EXPECT_EQ(nearest.distance, expected.distance);
      EXPECT_LE(nearest.others, distanceOfOthers(points, p, nearest.index));
      found += nearest.index != VoxelSearch::kNone;
    }
    return found;
  }
};

TEST_F(NearestVoxel, OfScatteredPointsIsThatOfASearchThroughAll) {
  const Points points = few();
  for (const double cell : {0.1, 0.3, 0.0})
    for (const double gate : {0.15, 0.5, 2.0}) {
      VoxelSearch search(points, cell);
      search.prepare(gate);
      EXPECT_GT(compareWithTwin(search, points, gate, kNothing), 3) << cell << ", " << gate;
    }
}

TEST_F(NearestVoxel, OfAnOctreesVoxelsIsThatOfASearchThroughAll) {
  const VoxelBlocks blocks(voxels().key);
  VoxelSearch search(voxels().centre, voxels().resolution, blocks);
  search.prepare(0.6);
  for (const double gate : {0.15, 0.3, 0.6})
    EXPECT_GT(compareWithTwin(search, voxels().centre, gate, kNothing), 10) << gate;
}

TEST_F(NearestVoxel, CountsWhatIsAddedToADistance) {
  const Points points = few();
  const auto extra = [](uint32_t i) { return 0.01F * static_cast<float>(i * 7919 % 101); };
  VoxelSearch search(points, 0.1);
  search.prepare(1.5);
  EXPECT_GT(compareWithTwin(search, points, 1.5, extra), 20);
}

TEST_F(NearestVoxel, IsFoundWithAGridThatIsCoarserForAWideGate) {
  const Points points = few();
  VoxelSearch search(points, 0.05);
  search.prepare(0.2);
  search.prepare(6);
  EXPECT_EQ(search.gate(), 6);
  search.prepare(1);
  EXPECT_EQ(search.gate(), 6) << "the widest that it is prepared for";
  EXPECT_GT(compareWithTwin(search, points, 6, kNothing), 100);
}

TEST_F(NearestVoxel, TellsThatTheOthersAreBeyondTheGateIfNoneIsWithin) {
  const Points points = few();
  VoxelSearch search(points, 0.1);
  search.prepare(0.5);
  int none = 0;
  for (const Eigen::Vector3f& p : queries(150)) {
    const Nearest nearest = search.nearest(p, {VoxelSearch::kNone, 0.25F}, kNothing);
    if (nearest.index != VoxelSearch::kNone) continue;
    none++;
    EXPECT_GE(nearest.others, 0.25F);
  }
  EXPECT_GT(none, 20);
}

TEST_F(NearestVoxel, BeginsWithAPointThatIsKnown) {
  const Points points = few();
  VoxelSearch search(points, 0.1);
  search.prepare(2);
  for (const Eigen::Vector3f& p : queries(100)) {
    const Nearest expected = nearestOfAll(points, p, 4.F, kNothing);
    if (expected.index == VoxelSearch::kNone) continue;
    for (const uint32_t known : {expected.index, expected.index / 2}) {
      const float distance = (points[known] - p).squaredNorm();
      if (distance >= 4) continue;
      const Nearest nearest = search.nearest(p, {known, distance}, kNothing);
      EXPECT_EQ(nearest.distance, expected.distance);
      EXPECT_EQ(nearest.index, expected.index);
      EXPECT_LE(nearest.others, distanceOfOthers(points, p, nearest.index));
    }
  }
}

TEST(VoxelSearch, OfTwoAsNearTakesTheLowerIndex) {
  for (const bool swapped : {false, true}) {
    Points points = {{0.15F, 0.05F, 0.05F}, {0.35F, 0.05F, 0.05F}};
    if (swapped) std::swap(points[0], points[1]);
    VoxelSearch search(points, 0.1);
    search.prepare(1);
    const Eigen::Vector3f middle = 0.5F * (points[0] + points[1]);
    ASSERT_EQ((points[0] - middle).squaredNorm(), (points[1] - middle).squaredNorm());
    const Nearest nearest = search.nearest(middle, {VoxelSearch::kNone, 1.F}, kNothing);
    EXPECT_EQ(nearest.index, 0U);
    EXPECT_EQ(nearest.others, nearest.distance) << "the other is no farther";
  }
}

TEST(VoxelSearch, ThePointAtTheGateIsOutside) {
  const Points points = {{0.5F, 0, 0}};
  VoxelSearch search(points, 0.25);
  search.prepare(1);
  const Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  EXPECT_EQ(search.nearest(origin, {VoxelSearch::kNone, 0.25F}, kNothing).index,
            VoxelSearch::kNone);
  EXPECT_EQ(
      search.nearest(origin, {VoxelSearch::kNone, std::nextafter(0.25F, 1.F)}, kNothing).index, 0U);
}

TEST(VoxelSearch, FarOutsideOfTheGridFindsNoneAndPromisesNothing) {
  const Points points = {{0, 0, 0}, {1, 1, 1}};
  VoxelSearch search(points, 0.1);
  search.prepare(1);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (const float x : {1e9F, -1e9F, kNan}) {
    const Nearest nearest = search.nearest({x, 0, 0}, {VoxelSearch::kNone, 1.F}, kNothing);
    EXPECT_EQ(nearest.index, VoxelSearch::kNone) << x;
    EXPECT_EQ(nearest.others, 0) << x;
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::voxel_search_test
