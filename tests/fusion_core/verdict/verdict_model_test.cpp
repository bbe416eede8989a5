// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the step from evidence to probability. */
#include <gtest/gtest.h>
#include <mrpt/fusion/evaluation.h>

#include <cmath>

namespace mrpt::fusion::test::verdict_model_test {
namespace {

/** A model that sees nothing. */
VerdictModel blind() {
  VerdictModel model;
  model.constant = model.log_overlap = model.conflict_ratio = model.runner_up = model.inlier_ratio =
      0;
  return model;
}

TEST(VerdictModel, WithoutEvidenceIsAHalf) {
  EXPECT_DOUBLE_EQ(blind().probability(0.5, 0.1, 0.3, 0.9), 0.5);
}

TEST(VerdictModel, EachCoefficientWeighsItsOwnMeasure) {
  const auto logOdds = [](const VerdictModel& model) {
    const double p = model.probability(0.5, 0.125, 0.25, 0.75);
    return std::log(p / (1 - p));
  };
  VerdictModel model = blind();
  model.constant = -1;
  EXPECT_NEAR(logOdds(model), -1, 1e-9);
  model = blind();
  model.log_overlap = 2;
  EXPECT_NEAR(logOdds(model), 2 * std::log(0.5), 1e-9);
  model = blind();
  model.conflict_ratio = -8;
  EXPECT_NEAR(logOdds(model), -1, 1e-9);
  model = blind();
  model.runner_up = -8;
  EXPECT_NEAR(logOdds(model), -2, 1e-9);
  model = blind();
  model.inlier_ratio = 4;
  EXPECT_NEAR(logOdds(model), 3, 1e-9);
}

TEST(VerdictModel, AddsUpAllEvidence) {
  VerdictModel model;
  model.constant = 1;
  model.log_overlap = 2;
  model.conflict_ratio = -3;
  model.runner_up = -4;
  model.inlier_ratio = 5;
  const double log_odds = 1 + 2 * std::log(0.4) - 3 * 0.05 - 4 * 0.2 + 5 * 0.9;
  EXPECT_NEAR(model.probability(0.4, 0.05, 0.2, 0.9), 1 / (1 + std::exp(-log_odds)), 1e-12);
}

TEST(VerdictModel, OverlapsBelowTheLeastCountAsTheLeast) {
  VerdictModel model;
  model.min_overlap = 0.1;
  const double least = model.probability(0.1, 0, 0, 1);
  EXPECT_EQ(model.probability(0.05, 0, 0, 1), least);
  EXPECT_EQ(model.probability(0, 0, 0, 1), least);
  EXPECT_GT(model.probability(0.11, 0, 0, 1), least);
}

TEST(VerdictModel, StaysAProbabilityWhateverTheEvidence) {
  VerdictModel model;
  for (const double extreme : {-1e9, 1e9}) {
    model.constant = extreme;
    const double p = model.probability(0.5, 0, 0, 1);
    EXPECT_EQ(p, extreme > 0 ? 1 : 0);
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::verdict_model_test
