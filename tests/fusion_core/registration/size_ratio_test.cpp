// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the measured size of map B over the size of map A. */
#include "fusion_core/registration/size_ratio.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "fusion_core/verdict/evaluation.h"
#include "support/apartment_pair.h"
#include "support/matching_tools.h"

namespace mrpt::fusion::test::size_ratio_test {
namespace {

/** Map B of a pair, with all lengths multiplied by \a factor. */
std::unique_ptr<octomap::OcTree> scaled(const octomap::OcTree& map, double factor) {
  auto copy = std::make_unique<octomap::OcTree>(map);
  copy->setResolution(factor * map.getResolution());
  return copy;
}

/** The match of a pair whose map B is scaled, from the true pose. */
struct ScaledPair {
  explicit ScaledPair(double factor)
      : map_b(scaled(*pair().map_b, factor)), b(allFeaturesOf(*map_b)) {
    // The place that both maps share is about the middle of B.
    const Eigen::Vector3d middle = meanOf(pair().b.voxels.centre);
    Eigen::Isometry3d start = pair().truth;
    start.translation() += pair().truth.linear() * ((1 - factor) * middle);
    match = matchMaps(pair().a, b, start, options);
    evaluation = judge(pair().a, b, match, options.evaluation);
  }
  static const ApartmentPair& pair() {
    static const ApartmentPair apartment(0.1);
    return apartment;
  }
  bool namesTheScale() const {
    for (const std::string& reason : evaluation.reasons)
      if (reason.find("map B seems to be scaled by ") == 0) return true;
    return false;
  }

  const Options options{};
  std::unique_ptr<octomap::OcTree> map_b;
  MapFeatures b;
  MatchResult match;
  Evaluation evaluation;
};

TEST(SizeRatio, IsOneForMapsOfTheSameSize) {
  const ScaledPair same(1);
  EXPECT_NEAR(same.match.size_ratio.value, 1, 0.005);
  EXPECT_LT(same.match.size_ratio.deviation, 0.02);
  EXPECT_FALSE(same.namesTheScale());
  EXPECT_TRUE(same.evaluation.accepted);
}

TEST(SizeRatio, IsMeasuredAndNamedIfMapBIsScaled) {
  for (const double factor : {0.95, 1.05}) {
    const ScaledPair pair(factor);
    EXPECT_NEAR(pair.match.size_ratio.value, factor, 0.015);
    EXPECT_TRUE(pair.namesTheScale()) << factor;
    EXPECT_FALSE(pair.evaluation.accepted) << factor;
  }
}

TEST(SizeRatio, IsUnknownWithoutPairs) {
  const ApartmentPair& pair = ScaledPair::pair();
  const RegistrationParams params;
  const VoxelAssociation association = associationOf(pair.a, pair.b, params);
  const SizeRatio ratio =
      sizeRatioAt(pair.a.matched, pair.b.matched, {}, pair.truth, association, 0.1, params);
  EXPECT_EQ(ratio.value, 1);
  EXPECT_TRUE(std::isinf(ratio.deviation));
}

}  // namespace
}  // namespace mrpt::fusion::test::size_ratio_test
