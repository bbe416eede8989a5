// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of poses that are compared with one another. */
#include "fusion_core/verdict/hypotheses.h"

#include <gtest/gtest.h>
#include <mrpt/fusion/options.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "fusion_core/map/map_voxels.h"
#include "support/apartment_pair.h"
#include "support/matching_tools.h"

namespace mrpt::fusion::test::hypotheses_test {
namespace {

// ---------------------------------------------------------------- distances and rough parameters

TEST(DistanceBetween, IsOneAtTheTolerance) {
  const PoseTolerance tolerance{0.6, 6 * kDegree};
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  EXPECT_EQ(distanceBetween(kIdentity, kIdentity, origin, tolerance), 0);
  EXPECT_NEAR(distanceBetween(kIdentity, poseOf(0, 0.6, 0, 0), origin, tolerance), 1, 1e-9);
  EXPECT_NEAR(distanceBetween(kIdentity, poseOf(0, 0, 0, 6), origin, tolerance), 1, 1e-9);
  EXPECT_NEAR(distanceBetween(kIdentity, poseOf(0, 0, 0, 0, 0, -12), origin, tolerance), 2, 1e-9);
}

TEST(DistanceBetween, TheLargerPartCounts) {
  const PoseTolerance tolerance{0.6, 6 * kDegree};
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  EXPECT_NEAR(distanceBetween(kIdentity, poseOf(0.3, 0, 0, 4.5), origin, tolerance), 0.75, 1e-9);
  EXPECT_NEAR(distanceBetween(kIdentity, poseOf(0.3, 0, 0, 1.5), origin, tolerance), 0.5, 1e-9);
}

TEST(DistanceBetween, IsThatOfTheMiddleOfMapB) {
  const PoseTolerance tolerance{0.6, 60 * kDegree};
  const Eigen::Vector3d middle(100, 0, 0);
  const Eigen::Isometry3d turned = poseOf(0, 0, 0, 1);
  EXPECT_NEAR(distanceBetween(kIdentity, turned, middle, tolerance),
              2 * 100 * std::sin(0.5 * kDegree) / 0.6, 1e-6);
  const Eigen::Isometry3d about_middle =
      Eigen::Translation3d(middle) * turned * Eigen::Translation3d(-middle);
  EXPECT_NEAR(distanceBetween(kIdentity, about_middle, middle, tolerance), 1 / 60., 1e-6);
}

TEST(DistanceBetween, IsTheSameFromAnyFrameAndEitherWay) {
  const PoseTolerance tolerance;
  const Eigen::Vector3d middle(3, -2, 1);
  const Eigen::Isometry3d T = poseOf(1, 2, 3, 40, 5, -6), U = T * poseOf(0.1, 0.2, 0, 3);
  const Eigen::Isometry3d frame = poseOf(-7, 50, 2, 120, 30, 10);
  const double d = distanceBetween(T, U, middle, tolerance);
  EXPECT_GT(d, 0.1);
  EXPECT_NEAR(distanceBetween(U, T, middle, tolerance), d, 1e-9);
  EXPECT_NEAR(distanceBetween(frame * T, frame * U, middle, tolerance), d, 1e-9);
}

TEST(Roughly, TakesTheCoarserOfBothParameters) {
  RegistrationParams registration;
  RankingParams ranking;
  registration.voxel_level.max_iterations = 30;
  registration.solver.max_steps = 10;
  registration.min_step_translation = 0.001;
  registration.min_step_rotation = 0.01;
  ranking.max_iterations = 15;
  ranking.min_step_translation = 0.01;
  ranking.min_step_rotation = 0.002;
  const RegistrationParams rough = roughly(registration, ranking);
  EXPECT_EQ(rough.voxel_level.max_iterations, 15U);
  EXPECT_EQ(rough.min_step_translation, 0.01);
  EXPECT_EQ(rough.min_step_rotation, 0.01) << "coarser already";
  EXPECT_EQ(rough.solver.max_steps, 1U);
  registration.voxel_level.max_iterations = 5;
  EXPECT_EQ(roughly(registration, ranking).voxel_level.max_iterations, 5U);
  EXPECT_EQ(rough.edge_level.max_iterations, registration.edge_level.max_iterations);
}

// ---------------------------------------------------------------- poses of two maps

class Hypotheses : public testing::Test {
 protected:
  static const ApartmentPair& maps() {
    static const ApartmentPair pair(0.2);
    return pair;
  }
  static const MapFeatures& a() { return maps().a; }
  static const MapFeatures& b() { return maps().b; }
  /** A hypothesis of which nothing else is known. */
  static RankedPose ranked(const Eigen::Isometry3d& T, double agreement) {
    return {T, agreement, kUnknownVariance * Matrix6d::Identity()};
  }
  static double fromTheTruth(const Eigen::Isometry3d& T) { return metresBetween(T, maps().truth); }

  const Options options{};
  const ComparisonParams params = comparisonOf(options);
  const VoxelAssociation association = associationOf(a(), b(), options.registration);
  const Eigen::Vector3d middle = meanOf(b().matched.voxels.centre);
  const Eigen::Isometry3d truth = maps().truth;
  const Eigen::Isometry3d wrong = truth * poseOf(3, 1, 0, 25);
};

TEST_F(Hypotheses, AComparisonTakesNoMoreVoxelsThanItIsGiven) {
  const SurfaceVoxels few = PoseComparison::voxelsOf(b(), params, 250);
  EXPECT_LE(few.voxels.size(), 250U);
  EXPECT_GT(few.voxels.size(), 100U);
  EXPECT_EQ(few.surfaces.normal.size(), few.voxels.size());
}

TEST_F(Hypotheses, AgreementIsThatOfTheVoxelsCompared) {
  const PoseComparison comparison(a(), b(), association, params, 1000);
  const Obstacles of_a = obstaclesOf(a(), PoseComparison::voxelsOf(a(), params, 1000));
  const Obstacles of_b = obstaclesOf(b(), PoseComparison::voxelsOf(b(), params, 1000));
  for (const Eigen::Isometry3d& T : {truth, wrong})
    EXPECT_EQ(comparison.agreementAt(T), agreement(a(), of_a, b(), of_b, T));
  EXPECT_GT(comparison.agreementAt(truth), comparison.agreementAt(wrong));
}

TEST_F(Hypotheses, AreRefinedDistinctAndBestFirst) {
  const PoseComparison comparison(a(), b(), association, params, 1000);
  const auto found = comparison.ranked(
      {wrong, truth * poseOf(0.2, 0.1, 0, 2), truth, truth * poseOf(-0.2, 0, 0.1, -2), wrong});
  ASSERT_GE(found.size(), 2U);
  ASSERT_LT(found.size(), 5U) << "starts that lead to the same place";
  EXPECT_LT(fromTheTruth(found[0].T_a_b), 0.1);
  EXPECT_LT(degreesBetween(found[0].T_a_b, truth), 1);
  for (size_t i = 0; i < found.size(); i++) {
    EXPECT_EQ(found[i].agreement, comparison.agreementAt(found[i].T_a_b));
    for (size_t j = 0; j < i; j++) {
      EXPECT_GE(found[j].agreement, found[i].agreement);
      EXPECT_GT(distanceBetween(found[i].T_a_b, found[j].T_a_b, middle, params.tolerance), 1);
    }
  }
  EXPECT_TRUE(comparison.ranked({}).empty());
}

TEST_F(Hypotheses, CovarianceIsKnownWhereTheMapsMeetOnly) {
  const PoseComparison comparison(a(), b(), association, params, 1000);
  EXPECT_LT(comparison.covarianceAt(truth).diagonal().maxCoeff(), 0.1);
  EXPECT_GT(comparison.covarianceAt(truth * poseOf(60, 0, 0, 0)).diagonal().minCoeff(), 1);
}

TEST_F(Hypotheses, RivalsAreComparedOnceMore) {
  // By few voxels the wrong pose looked better.
  std::vector<RankedPose> hypotheses = {ranked(wrong, 110), ranked(truth, 100)};
  compareRivals(a(), b(), association, params, hypotheses);
  ASSERT_EQ(hypotheses.size(), 2U);
  EXPECT_LT(fromTheTruth(hypotheses[0].T_a_b), 0.1);
  EXPECT_GT(fromTheTruth(hypotheses[1].T_a_b), 1);
  EXPECT_GT(hypotheses[0].agreement, hypotheses[1].agreement);
}

TEST_F(Hypotheses, TheOthersStayAsFarBehindTheRivals) {
  const Eigen::Isometry3d last = truth * poseOf(-4, 2, 0, 100);
  std::vector<RankedPose> hypotheses = {ranked(truth, 100), ranked(wrong, 50), ranked(last, 1)};
  compareRivals(a(), b(), association, params, hypotheses);
  const auto& behind = *std::find_if(hypotheses.begin(), hypotheses.end(), [&](const auto& h) {
    return h.T_a_b.matrix() == last.matrix();
  });
  EXPECT_NEAR(behind.agreement / hypotheses.front().agreement, 0.01, 1e-9);
}

TEST_F(Hypotheses, WithoutARivalNothingIsComparedAgain) {
  std::vector<RankedPose> hypotheses = {ranked(truth, 100), ranked(wrong, 4.9)};
  compareRivals(a(), b(), association, params, hypotheses);
  ASSERT_EQ(hypotheses.size(), 2U);
  EXPECT_EQ(hypotheses[0].agreement, 100);
  EXPECT_EQ(hypotheses[1].agreement, 4.9);
  EXPECT_EQ(hypotheses[0].T_a_b.matrix(), truth.matrix());
}

// ---------------------------------------------------------------- what all voxels lead to

TEST_F(Hypotheses, APoseThatAllVoxelsLedToIsTheFirst) {
  MatchResult result;
  result.T_a_b = truth;
  result.covariance = 0.01 * Matrix6d::Identity();
  result.hypotheses = {ranked(wrong, 100), ranked(truth * poseOf(0.1, 0, 0, 1), 90)};
  compareWhatWasReached(a(), b(), association, params, result);
  ASSERT_EQ(result.hypotheses.size(), 2U) << "the pose at the same place is left out";
  EXPECT_EQ(result.hypotheses[0].T_a_b.matrix(), truth.matrix());
  EXPECT_EQ(result.hypotheses[0].covariance, result.covariance);
  EXPECT_EQ(result.hypotheses[1].T_a_b.matrix(), wrong.matrix());
  EXPECT_GT(result.hypotheses[0].agreement, result.hypotheses[1].agreement);
}

TEST_F(Hypotheses, APoseThatAllVoxelsLedToIsTheFirstWhateverItIsWorth) {
  MatchResult result;
  result.T_a_b = wrong;
  result.hypotheses = {ranked(truth, 100)};
  compareWhatWasReached(a(), b(), association, params, result);
  ASSERT_EQ(result.hypotheses.size(), 2U);
  EXPECT_EQ(result.hypotheses[0].T_a_b.matrix(), wrong.matrix());
  EXPECT_GT(result.runnerUp(), 1);
}

TEST_F(Hypotheses, APoseThatAllVoxelsMovedLittleIsNotComparedAgain) {
  MatchResult result;
  result.T_a_b = truth * poseOf(0.05, 0, 0, 0.5);
  result.hypotheses = {ranked(truth, 100), ranked(wrong, 90)};
  compareWhatWasReached(a(), b(), association, params, result);
  ASSERT_EQ(result.hypotheses.size(), 2U);
  EXPECT_EQ(result.hypotheses[0].agreement, 100);
  EXPECT_EQ(result.hypotheses[1].agreement, 90);
}

TEST_F(Hypotheses, TheChosenHypothesisIsFollowedByTheOthersBestFirst) {
  std::vector<RankedPose> hypotheses = {ranked(wrong, 1), ranked(truth, 3), ranked(wrong, 2)};
  makeFirst(2, hypotheses);
  EXPECT_EQ(hypotheses[0].agreement, 2);
  EXPECT_EQ(hypotheses[1].agreement, 3);
  EXPECT_EQ(hypotheses[2].agreement, 1);
}

// ---------------------------------------------------------------- a pose elsewhere

TEST_F(Hypotheses, AMuchBetterPoseElsewhereBecomesTheSecond) {
  for (const bool has_hypotheses : {false, true}) {
    MatchResult result;
    result.T_a_b = wrong;
    if (has_hypotheses)
      result.hypotheses = {ranked(wrong, 20), ranked(truth * poseOf(-6, 0, 0, 0), 10)};
    const auto better = betterPoseElsewhere(a(), b(), wrong, truth, 0.75, params);
    ASSERT_TRUE(better);
    insertBetter(*better, result);
    ASSERT_EQ(result.hypotheses.size(), has_hypotheses ? 3U : 2U);
    EXPECT_EQ(result.T_a_b.matrix(), wrong.matrix()) << "the match itself stays";
    EXPECT_EQ(result.hypotheses[0].T_a_b.matrix(), wrong.matrix());
    EXPECT_LT(fromTheTruth(result.hypotheses[1].T_a_b), 0.1);
    EXPECT_GT(result.runnerUp(), 1 / 0.75);
    if (has_hypotheses) {
      EXPECT_EQ(result.hypotheses[0].agreement, 20);
    }
  }
}

TEST_F(Hypotheses, APoseElsewhereMustBeClearlyBetterAndAnotherPlace) {
  for (const Eigen::Isometry3d& elsewhere : {wrong, truth, truth * poseOf(0.1, 0, 0, 1)})
    EXPECT_FALSE(betterPoseElsewhere(a(), b(), truth, elsewhere, 0.75, params));
}

TEST_F(Hypotheses, ARivalTakesItsPlaceByAgreement) {
  const Eigen::Isometry3d other = truth * poseOf(-6, 0, 0, 0);
  MatchResult result;
  result.hypotheses = {ranked(truth, 20), ranked(other, 10)};
  addRival(b(), ranked(wrong, 0), 0.7, params.tolerance, result);
  ASSERT_EQ(result.hypotheses.size(), 3U);
  EXPECT_EQ(result.hypotheses[1].T_a_b.matrix(), wrong.matrix());
  EXPECT_DOUBLE_EQ(result.runnerUp(), 0.7);
  // A place is held once, with its larger agreement.
  addRival(b(), ranked(other, 0), 0.2, params.tolerance, result);
  ASSERT_EQ(result.hypotheses.size(), 3U);
  EXPECT_EQ(result.hypotheses[2].agreement, 10);
  addRival(b(), ranked(other, 0), 0.9, params.tolerance, result);
  ASSERT_EQ(result.hypotheses.size(), 3U);
  EXPECT_EQ(result.hypotheses[1].T_a_b.matrix(), other.matrix());
}

}  // namespace
}  // namespace mrpt::fusion::test::hypotheses_test
