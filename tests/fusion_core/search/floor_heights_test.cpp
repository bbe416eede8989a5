// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the heights that lay floors on floors. */
#include "fusion_core/search/floor_heights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <vector>

namespace mrpt::fusion::test::floor_heights_test {
namespace {

using Layers = std::vector<double>;

/** The twin: the product of layers that lie on each other, by shift in layers. */
std::map<int, double> fitOfShifts(const Layers& a, int low_a, const Layers& b, int low_b,
                                  int reach) {
  std::map<int, double> fit;
  for (int s = -reach; s <= reach; s++)
    for (int i = 0; i < static_cast<int>(a.size()); i++)
      for (int k = 0; k < static_cast<int>(b.size()); k++)
        if (low_a + i == low_b + k + s)
          fit[s] += a[static_cast<size_t>(i)] * b[static_cast<size_t>(k)];
  return fit;
}

TEST(AlignFloors, LaysTheFloorOnTheFloor) {
  // A floor and a ceiling 2.6 m above it; B knows the floor best, 0.4 m lower in its own frame.
  Layers a(30, 1), b(30, 1);
  a[2] = 100;
  a[28] = 80;
  b[6] = 90;
  const auto found = alignFloors(a, 0, b, -8, 0.1, 5, 0.6);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->shift, 0.4, 1e-9) << "layer 6 of B is number -2, layer 2 of A is number 2";
}

TEST(AlignFloors, FindsNothingBeyondTheLargestShift) {
  Layers a(3, 0), b(3, 0);
  a[1] = b[1] = 1;
  EXPECT_NEAR(alignFloors(a, 20, b, 0, 0.1, 2, 0.6)->shift, 2, 1e-9);
  EXPECT_FALSE(alignFloors(a, 20, b, 0, 0.1, 1.9, 0.6));
  EXPECT_NEAR(alignFloors(a, -20, b, 0, 0.1, 2, 0.6)->shift, -2, 1e-9);
  EXPECT_FALSE(alignFloors(a, -20, b, 0, 0.1, 1.9, 0.6));
}

TEST(AlignFloors, WithoutBoundsGoesAsFarAsTheMapsCanMeet) {
  Layers a(3, 0), b(3, 0);
  a[0] = b[2] = 1;
  EXPECT_NEAR(alignFloors(a, 500, b, -500, 0.1, INFINITY, 0.6)->shift, 99.8, 1e-9);
}

TEST(AlignFloors, OtherStoreysArePlausibleAndCeilingsAreNot) {
  // Two storeys of 30 layers in A, one in B. A floor has more obstacles than a ceiling.
  Layers a(70, 0), b(30, 0);
  a[5] = a[35] = 100;
  a[28] = a[58] = 20;
  b[5] = 100;
  b[28] = 20;
  const auto found = alignFloors(a, 0, b, 0, 0.1, 10, 0.6);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->shift, 0, 1e-9) << "the lower of two as good";
  EXPECT_NEAR(found->plausible[0], 0, 1e-9);
  EXPECT_NEAR(found->plausible[1], 3, 1e-9);
  const auto generous = alignFloors(a, 0, b, 0, 0.1, 10, 0.1);
  EXPECT_NEAR(generous->plausible[0], -2.3, 1e-9) << "B's ceiling on A's floor";
  EXPECT_NEAR(generous->plausible[1], 5.3, 1e-9) << "B's floor on A's upper ceiling";
}

TEST(AlignFloors, OfMapsWithoutObstaclesFindsNothing) {
  EXPECT_FALSE(alignFloors({}, 0, {}, 0, 0.1, 5, 0.6));
  EXPECT_FALSE(alignFloors({1, 1}, 0, {}, 0, 0.1, 5, 0.6));
  EXPECT_FALSE(alignFloors({}, 0, {1, 1}, 0, 0.1, 5, 0.6));
  EXPECT_FALSE(alignFloors({0, 0}, 0, {1, 1}, 0, 0.1, 5, 0.6));
}

TEST(AlignFloors, IsTheBestOfAllShifts) {
  std::mt19937 random(1);
  const auto layers = [&] {
    Layers all(1 + random() % 40);
    for (double& n : all) n = static_cast<double>(random() % 5 == 0 ? random() % 50 : 0);
    return all;
  };
  int found_some = 0;
  for (int i = 0; i < 300; i++) {
    const Layers a = layers(), b = layers();
    const int low_a = static_cast<int>(random() % 60) - 30;
    const int low_b = static_cast<int>(random() % 60) - 30;
    const int reach = static_cast<int>(random() % 50);
    const double step = 0.25, share = 0.5;
    const auto fit = fitOfShifts(a, low_a, b, low_b, reach);
    double best = 0;
    for (const auto& [s, f] : fit) best = std::max(best, f);
    const auto found = alignFloors(a, low_a, b, low_b, step, step * reach, share);
    ASSERT_EQ(found.has_value(), best > 0) << i;
    if (!found) continue;
    found_some++;
    const int shift = static_cast<int>(std::lround(found->shift / step));
    EXPECT_EQ(fit.at(shift), best) << i;
    std::vector<int> plausible;
    for (const auto& [s, f] : fit)
      if (f >= share * best) plausible.push_back(s);
    EXPECT_DOUBLE_EQ(found->plausible[0], step * (plausible.front() - shift)) << i;
    EXPECT_DOUBLE_EQ(found->plausible[1], step * (plausible.back() - shift)) << i;
  }
  EXPECT_GT(found_some, 100);
}

}  // namespace
}  // namespace mrpt::fusion::test::floor_heights_test
