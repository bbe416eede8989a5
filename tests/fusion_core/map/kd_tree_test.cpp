// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the kd-tree over descriptors, against a search through all points. */
#include "fusion_core/map/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <vector>

namespace mrpt::fusion::test::kd_tree_test {
namespace {

using Tree = KdTree<4>;
using Descriptor = Tree::Descriptor;
constexpr float kFar = std::numeric_limits<float>::max();

float squaredDistance(const Descriptor& a, const Descriptor& b, const Descriptor& weights) {
  float sum = 0;
  for (size_t d = 0; d < 4; d++) sum += weights[d] * (a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

/** The twin: the first of the nearest points closer than the gate. */
std::optional<Tree::Nearest> nearestOfAll(const std::vector<Descriptor>& points,
                                          const Descriptor& query, float squared_gate,
                                          const Descriptor& weights) {
  std::optional<Tree::Nearest> best;
  for (uint32_t i = 0; i < points.size(); i++) {
    const float d = squaredDistance(query, points[i], weights);
    if (d < (best ? best->squared_distance : squared_gate)) best = Tree::Nearest{i, d};
  }
  return best;
}

/** Points on a lattice, where many are as near as others, and some twice. */
std::vector<Descriptor> latticePoints(size_t n, std::mt19937& random) {
  std::vector<Descriptor> points(n);
  for (Descriptor& p : points)
    for (float& x : p) x = static_cast<float>(random() % 7);
  return points;
}

std::vector<Descriptor> scatteredPoints(size_t n, std::mt19937& random) {
  std::uniform_real_distribution<float> place(0, 6);
  std::vector<Descriptor> points(n);
  for (Descriptor& p : points)
    for (float& x : p) x = place(random);
  return points;
}

const std::vector<Descriptor> kWeights = {
    {1, 1, 1, 1}, {1, 1, 1, 0}, {0.25F, 4, 1, 2}, {0, 0, 0, 1}};

/** Compares all answers with the twin's. \return Number of queries that found a point. */
int compareWithTwin(const std::vector<Descriptor>& points, const std::vector<Descriptor>& queries) {
  Tree tree(points);
  int found = 0;
  for (const Descriptor& weights : kWeights) {
    tree.setWeights(weights);
    for (const Descriptor& query : queries)
      for (const float gate : {0.F, 0.25F, 1.F, 4.F, kFar}) {
        const auto expected = nearestOfAll(points, query, gate, weights);
        const auto nearest = tree.nearestWithin(query, gate);
        EXPECT_EQ(nearest.has_value(), expected.has_value()) << "gate " << gate;
        if (!nearest || !expected) continue;
        found++;
        EXPECT_EQ(nearest->index, expected->index);
        EXPECT_EQ(nearest->squared_distance, expected->squared_distance);
      }
  }
  return found;
}

TEST(KdTree, FindsWhatASearchThroughAllPointsFinds) {
  std::mt19937 random(1);
  const auto points = scatteredPoints(2000, random);
  EXPECT_GT(compareWithTwin(points, scatteredPoints(200, random)), 1000);
}

TEST(KdTree, OfPointsAsNearTakesTheLowestIndex) {
  std::mt19937 random(2);
  const auto points = latticePoints(2000, random);
  auto queries = latticePoints(200, random);
  for (size_t i = 0; i < queries.size(); i += 2) queries[i][i % 4] += 0.5F;  // between two
  EXPECT_GT(compareWithTwin(points, queries), 1000);
}

TEST(KdTree, ThePointAtTheGateIsOutside) {
  const Tree tree({{2, 0, 0, 0}});
  EXPECT_FALSE(tree.nearestWithin({0, 0, 0, 0}, 4));
  const auto nearest = tree.nearestWithin({0, 0, 0, 0}, std::nextafter(4.F, 5.F));
  ASSERT_TRUE(nearest);
  EXPECT_EQ(nearest->squared_distance, 4);
}

TEST(KdTree, WeightsDecideWhichIsNearest) {
  Tree tree({{3, 0, 0, 0}, {0, 2, 0, 0}});
  EXPECT_EQ(tree.nearestWithin({0, 0, 0, 0}, kFar)->index, 1U) << "all 1 at first";
  tree.setWeights({1, 4, 1, 1});
  EXPECT_EQ(tree.nearestWithin({0, 0, 0, 0}, kFar)->index, 0U);
  tree.setWeights({1, 1, 1, 1});
  EXPECT_EQ(tree.nearestWithin({0, 0, 0, 0}, kFar)->index, 1U);
}

TEST(KdTree, GivesTheNearestFewInOrder) {
  std::mt19937 random(3);
  const auto points = scatteredPoints(500, random);
  const Tree tree(points);
  for (const Descriptor& query : scatteredPoints(50, random))
    for (const size_t k : {1, 8, 100}) {
      std::vector<float> expected;
      for (const auto& p : points) expected.push_back(squaredDistance(query, p, kWeights[0]));
      std::sort(expected.begin(), expected.end());
      expected.resize(k);
      const auto nearest = tree.nearest(query, k);
      EXPECT_EQ(nearest.squared_distance, expected);
      ASSERT_EQ(nearest.index.size(), k);
      for (size_t i = 0; i < k; i++)
        EXPECT_EQ(squaredDistance(query, tree.point(nearest.index[i]), kWeights[0]), expected[i]);
    }
}

TEST(KdTree, GivesAllPointsIfThereAreFewer) {
  const Tree tree({{0, 0, 0, 0}, {1, 0, 0, 0}});
  const auto nearest = tree.nearest({0.9F, 0, 0, 0}, 5);
  EXPECT_EQ(nearest.index, (std::vector<uint32_t>{1, 0}));
  EXPECT_EQ(nearest.squared_distance.size(), 2U);
}

TEST(KdTree, OfNoPointsFindsNone) {
  const Tree tree({});
  EXPECT_FALSE(tree.nearestWithin({0, 0, 0, 0}, kFar));
}

TEST(ToDescriptors, KeepsTheCoordinates) {
  const auto d = toDescriptors({{1, 2, 3}, {-4, 5, -6}});
  EXPECT_EQ(d, (std::vector<std::array<float, 3>>{{1, 2, 3}, {-4, 5, -6}}));
}

}  // namespace
}  // namespace mrpt::fusion::test::kd_tree_test
