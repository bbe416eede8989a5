// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_team/graph/place_model.h"

#include <gtest/gtest.h>

namespace mrpt::fusion::test::place_model_test {
namespace {

TEST(PlaceModel, EachEvidenceCountsInItsDirection) {
  const PlaceModel model;
  const double p = model.probability(0.4, 0.4);
  EXPECT_GT(p, 0.85);
  EXPECT_LT(p, 1);
  EXPECT_LT(model.probability(0.9, 0.4), p) << "a rival";
  EXPECT_LT(model.probability(0.4, 0.02), p) << "maps that hardly meet";
}

TEST(PlaceModel, ARivalThatGainsMoreIsAsGood) {
  const PlaceModel model;
  EXPECT_EQ(model.probability(16, 0.4), model.probability(1, 0.4));
  EXPECT_GT(model.probability(0, 0), 0) << "no overlap is a small overlap";
}

TEST(PlaceModel, APoseThatTheTeamDoesNotPreferIsAtMostWhatIsLeft) {
  const PlaceModel model;
  EXPECT_NEAR(model.ofAnotherPose(0.99), 0.01, 1e-9);
  EXPECT_NEAR(model.ofAnotherPose(0.2), 0.2, 1e-9) << "the preferred place is the best place";
  EXPECT_LT(model.ofAnotherPose(std::nullopt), 0.5);
}

}  // namespace
}  // namespace mrpt::fusion::test::place_model_test
