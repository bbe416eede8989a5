// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of ratios as text. */

#include "fusion_base/percent_text.h"

#include <gtest/gtest.h>

using namespace mrpt::fusion;

namespace {

TEST(PercentText, HasOneDecimal) {
  EXPECT_EQ(percent(0), "0.0 %");
  EXPECT_EQ(percent(0.4567), "45.7 %");
  EXPECT_EQ(percent(1), "100.0 %");
}

TEST(PercentText, DiffersFromItsLimit) {
  EXPECT_EQ(percentBeside(0.9, 0.5), "50.0 %");
  EXPECT_EQ(percentBeside(0.9, 0.9004), "90.04 %");
  EXPECT_EQ(percentBeside(0.9, 0.8999), "89.99 %");
  EXPECT_EQ(percentBeside(0.9, 0.900004), "90.0004 %");
  EXPECT_EQ(percentBeside(0.9, 0.9), "90.0 %");
}

}  // namespace
