// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of a function that remembers its values. */
#include "fusion_base/remembered_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace mrpt::fusion::test::remembered_function_test {
namespace {

double cubed(float x) { return 1 + static_cast<double>(x) * x * x; }

TEST(RememberedFunction, IsTheFunctionForMoreArgumentsThanItRemembers) {
  RememberedFunction remembered(cubed);
  std::mt19937 random(1);
  std::vector<float> arguments = {0, 1, -1, 1e-30F, -3e30F, INFINITY, -INFINITY};
  for (int i = 0; i < 1000; i++)
    arguments.push_back(std::uniform_real_distribution<float>(-9, 9)(random));
  for (int i = 0; i < 20000; i++) {
    const float x = arguments[random() % arguments.size()];
    ASSERT_EQ(remembered(x), cubed(x)) << x;
  }
}

TEST(RememberedFunction, IsTheFunctionAtZeroFromTheFirstCallOn) {
  RememberedFunction remembered(cubed);
  EXPECT_EQ(remembered(0), 1);
  EXPECT_EQ(remembered(-0.F), 1);
}

TEST(RememberedFunction, ComputesAgainForWhatIsNotANumber) {
  RememberedFunction remembered(cubed);
  EXPECT_TRUE(std::isnan(remembered(NAN)));
  EXPECT_TRUE(std::isnan(remembered(NAN)));
  EXPECT_EQ(remembered(2), 9);
}

TEST(RememberedFunction, RemembersTheLastArgument) {
  int calls = 0;
  RememberedFunction remembered([&](float x) {
    calls++;
    return cubed(x);
  });
  remembered(0.7F);
  const int before = calls;
  for (int i = 0; i < 100; i++) EXPECT_EQ(remembered(0.7F), cubed(0.7F));
  EXPECT_EQ(calls, before);
}

TEST(RememberedFunction, RemembersMostOfAFewArguments) {
  int calls = 0;
  RememberedFunction remembered([&](float x) {
    calls++;
    return cubed(x);
  });
  // Log-odds as a sensor model adds them up: hits and misses.
  std::set<float> different;
  for (int round = 0; round < 100; round++)
    for (int hits = 0; hits < 8; hits++)
      for (int misses = 0; misses < 8; misses++) {
        const float x = 0.85F * static_cast<float>(hits) - 0.41F * static_cast<float>(misses);
        different.insert(x);
        remembered(x);
      }
  ASSERT_GT(different.size(), 50U);
  EXPECT_LT(calls, 6400 / 2);
}

}  // namespace
}  // namespace mrpt::fusion::test::remembered_function_test
