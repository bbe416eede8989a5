// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_base/whole_number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace mrpt::fusion {
namespace {

TEST(ToWhole, IsACastWhereACastIsDefined) {
  for (const double x : {0.0, 0.5, -0.5, 1.999, -1.999, 12345.6, -98765.4, 2e8, -2e8})
    EXPECT_EQ(toWhole(x), static_cast<int>(x)) << x;
}

TEST(ToWhole, BoundsAllOtherNumbers) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double x : {3e8, 1e10, 1e18, 1e308, kInfinity}) {
    EXPECT_EQ(toWhole(x), kMostWhole) << x;
    EXPECT_EQ(toWhole(-x), -kMostWhole) << x;
  }
  EXPECT_EQ(toWhole(std::nan("")), -kMostWhole);
}

}  // namespace
}  // namespace mrpt::fusion
