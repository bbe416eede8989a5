// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of lookups by point. */
#include "fusion_octree/walk.h"

#include <gtest/gtest.h>

#include <limits>

namespace mrpt::fusion {
namespace {

TEST(KeyAt, IsTheKeyOfOctomapUpToTheEndOfTheGrid) {
  const octomap::OcTree tree(0.1);
  for (const float x : {-3276.9F, -3276.75F, -0.05F, 0.F, 0.05F, 17.3F, 3276.75F, 3276.9F}) {
    octomap::OcTreeKey expected, found;
    const octomap::point3d p(x, 0.5F * x, -x);
    const bool is_inside = tree.coordToKeyChecked(p, expected);
    ASSERT_EQ(keyAt(tree, p, found), is_inside) << x;
    if (is_inside) {
      EXPECT_EQ(found, expected) << x;
    }
  }
}

TEST(KeyAt, ThereIsNoneOfFarPointsAndOfNoNumber) {
  const octomap::OcTree tree(0.1);
  octomap::OcTreeKey key;
  for (const float bad : {1e10F, -1e38F, std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN()})
    for (unsigned axis = 0; axis < 3; axis++) {
      octomap::point3d p(1, 2, 3);
      p(axis) = bad;
      EXPECT_FALSE(keyAt(tree, p, key)) << bad << " on axis " << axis;
    }
}

}  // namespace
}  // namespace mrpt::fusion
