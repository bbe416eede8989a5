// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of poses in both libraries, and of the searches that priors ask for. */
#include <gtest/gtest.h>
#include <mrpt/fusion/poses.h>

#include <cmath>
#include <exception>
#include <limits>
#include <vector>

#include "support/test_maps.h"

namespace mrpt::fusion::test::poses_test {
namespace {

using mrpt::poses::CPose3D;
using mrpt::poses::CPose3DPDFGaussian;

const std::vector<Eigen::Isometry3d>& manyPoses() {
  static const std::vector<Eigen::Isometry3d> poses = {
      kIdentity, poseOf(1, -2, 3, 0), poseOf(0, 0, 0, 179.9), poseOf(-5, 0.1, 2, -120, 35, -80),
      poseOf(1000, 2000, -30, 10, -89, 170)};
  return poses;
}

// ---------------------------------------------------------------- between the libraries

TEST(Poses, ComeBackFromMrpt) {
  for (const Eigen::Isometry3d& T : manyPoses())
    EXPECT_TRUE(toEigen(toPose(T)).isApprox(T, 1e-12)) << T.matrix();
}

TEST(Poses, OfMatricesKeepTheirBitsOrGetTheNearestRotation) {
  for (const Eigen::Isometry3d& T : manyPoses()) {
    EXPECT_EQ(toRigid(T.matrix()).matrix(), T.matrix());
    Eigen::Matrix4d rounded = (T.matrix() * 1e4).array().round() / 1e4;
    const Eigen::Isometry3d nearest = toRigid(rounded);
    EXPECT_TRUE(nearest.isApprox(T, 1e-4));
    EXPECT_LT(
        (nearest.linear().transpose() * nearest.linear() - Eigen::Matrix3d::Identity()).norm(),
        1e-12);
  }
}

TEST(Poses, OfMatricesThatAreNotRigidAreRefused) {
  const Eigen::Matrix4d good = Eigen::Matrix4d::Identity();
  std::vector<Eigen::Matrix4d> bad(5, good);
  bad[0] *= 2;
  bad[1](2, 2) = -1;  // a mirror image
  bad[2](3, 0) = 1;
  bad[3](0, 3) = std::numeric_limits<double>::infinity();
  bad[4](1, 1) = std::numeric_limits<double>::quiet_NaN();
  for (const auto& matrix : bad) EXPECT_THROW(toRigid(matrix), std::runtime_error) << matrix;
}

TEST(Poses, AreThoseOfMrptsAngles) {
  const Eigen::Isometry3d T = toEigen(CPose3D(1, 2, 3, 40 * kDegree, -20 * kDegree, 110 * kDegree));
  EXPECT_TRUE(T.isApprox(poseOf(1, 2, 3, 40, -20, 110), 1e-12));
  const CPose3D pose = toPose(poseOf(-4, 5, 6, 70, 15, -25));
  EXPECT_NEAR(pose.x(), -4, 1e-12);
  EXPECT_NEAR(pose.yaw(), 70 * kDegree, 1e-12);
  EXPECT_NEAR(pose.pitch(), 15 * kDegree, 1e-12);
  EXPECT_NEAR(pose.roll(), -25 * kDegree, 1e-12);
}

TEST(Poses, ComposeAsMrptsDo) {
  for (const Eigen::Isometry3d& T : manyPoses())
    for (const Eigen::Isometry3d& U : manyPoses())
      EXPECT_TRUE(toEigen(toPose(T) + toPose(U)).isApprox(T * U, 1e-9));
}

// ---------------------------------------------------------------- what is known before

/** Standard deviations: x, y and z, m; yaw, rad. */
CPose3DPDFGaussian gaussianOf(double x, double y, double z, double yaw) {
  CPose3DPDFGaussian g(CPose3D(1, 2, 3, 0.4, 0, 0));
  const double sigma[] = {x, y, z, yaw};
  for (int i = 0; i < 4; i++) g.cov(i, i) = sigma[i] * sigma[i];
  return g;
}

void expectAsConfigured(const SearchParams& search, const SearchParams& configured) {
  EXPECT_EQ(search.translation, configured.translation);
  EXPECT_EQ(search.height, configured.height);
  EXPECT_EQ(search.yaw, configured.yaw);
  EXPECT_EQ(search.hypotheses, configured.hypotheses);
}

TEST(Prior, OfNothingHasEverywhereSearched) {
  const Prior prior = Prior::none();
  EXPECT_TRUE(prior.isNone());
  EXPECT_TRUE(toEigen(prior.guess()).isApprox(kIdentity, 0));
  EXPECT_EQ(prior.pdf().cov, noGuess().cov);
  const SearchParams configured, search = prior.searchWithin(configured);
  EXPECT_TRUE(search.isEverywhere());
  EXPECT_TRUE(std::isinf(search.height));
  EXPECT_GE(search.hypotheses, configured.budget.min_hypotheses_everywhere);
  EXPECT_EQ(search.cell, configured.cell);
}

TEST(Prior, NearAGuessHasSearchedWhatIsConfigured) {
  const CPose3D guess(1, 2, 3, 0.4, 0, 0);
  const Prior prior = Prior::near(guess);
  EXPECT_FALSE(prior.isNone());
  EXPECT_EQ(prior.guess(), guess);
  EXPECT_TRUE(prior.pdf().cov.asEigen().isZero(0));
  SearchParams configured;
  configured.translation = 1.5;
  configured.height = 0.1;
  configured.yaw = 0.7;
  configured.hypotheses = 9;
  expectAsConfigured(prior.searchWithin(configured), configured);
}

TEST(Prior, GaussianHasThreeStandardDeviationsSearched) {
  const Prior prior = Prior::gaussian(gaussianOf(0.5, 1.5, 0.25, 0.2));
  EXPECT_FALSE(prior.isNone());
  EXPECT_EQ(prior.guess().x(), 1);
  const SearchParams configured, search = prior.searchWithin(configured);
  EXPECT_NEAR(search.translation, 3 * 1.5, 1e-9) << "the larger of both";
  EXPECT_NEAR(search.height, 3 * 0.25, 1e-9);
  EXPECT_NEAR(search.yaw, 3 * 0.2, 1e-9);
  EXPECT_EQ(search.hypotheses, configured.hypotheses);
}

TEST(Prior, GaussianHasTheLongestAxisOfItsEllipseSearched) {
  CPose3DPDFGaussian diagonal = gaussianOf(1, 1, 0, 0);
  diagonal.cov(0, 1) = diagonal.cov(1, 0) = 0.75;  // 1.75 along a diagonal
  EXPECT_NEAR(Prior::gaussian(diagonal).searchWithin({}).translation, 3 * std::sqrt(1.75), 1e-9);
}

TEST(Prior, SearchesAtLeastACellAndAtMostAllTheWayRound) {
  const SearchParams configured;
  EXPECT_EQ(Prior::gaussian(gaussianOf(1e-3, 0, 0, 0)).searchWithin(configured).translation,
            configured.cell);
  EXPECT_EQ(Prior::gaussian(gaussianOf(1, 1, 1, 50)).searchWithin(configured).yaw, M_PI);
}

TEST(Prior, GaussianThatIsCertainIsSearchedAsNear) {
  const SearchParams configured;
  expectAsConfigured(Prior::gaussian(gaussianOf(0, 0, 0, 0)).searchWithin(configured), configured);
}

TEST(Prior, GaussianThatIsWideEnoughSaysNothing) {
  const double limit = kUnknownPoseSigma / kSearchSigmas;
  EXPECT_TRUE(Prior::gaussian(gaussianOf(1.01 * limit, 0, 0, 0)).isNone());
  EXPECT_TRUE(Prior::gaussian(gaussianOf(0, 1.01 * limit, 0, 0)).searchWithin({}).isEverywhere());
  EXPECT_FALSE(Prior::gaussian(gaussianOf(0.99 * limit, 0, 0, 0)).isNone());
  EXPECT_TRUE(Prior::gaussian(noGuess()).isNone());
}

TEST(Prior, NoSearchStaysNone) {
  SearchParams off;
  off.translation = 0;
  for (const Prior& prior : {Prior::none(), Prior::near(CPose3D()), Prior(gaussianOf(1, 1, 1, 1))})
    EXPECT_EQ(prior.searchWithin(off).translation, 0);
}

TEST(Prior, RefusesACovarianceThatIsNone) {
  for (const double bad :
       {-1e-9, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (int i = 0; i < 6; i++) {
      CPose3DPDFGaussian guess = gaussianOf(1, 1, 1, 1);
      guess.cov(i, i) = bad;
      EXPECT_THROW(Prior::gaussian(guess), std::exception) << i << ": " << bad;
      EXPECT_THROW((void)Prior(guess), std::exception) << i << ": " << bad;
    }
  CPose3DPDFGaussian guess = gaussianOf(1, 1, 1, 1);
  guess.cov(0, 5) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Prior::gaussian(guess), std::exception) << "off the diagonal";
}

TEST(Prior, WithinDeviationsSearchesThreeOfThem) {
  const Prior prior = Prior::within(CPose3D(1, 2, 0, 0.5, 0, 0), 0.5, 0.1);
  const SearchParams search = prior.searchWithin(SearchParams());
  EXPECT_NEAR(search.translation, 1.5, 1e-12);
  EXPECT_NEAR(search.height, 1.5, 1e-12);
  EXPECT_NEAR(search.yaw, 0.3, 1e-12);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {0.0, -0.1, nan}) {
    EXPECT_THROW(Prior::within(CPose3D(), bad, 0.1), std::exception);
    EXPECT_THROW(Prior::within(CPose3D(), 1, bad), std::exception);
  }
}

TEST(Prior, RefusesAGuessOutOfRange) {
  for (const double far : {1e9, -1e18, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()})
    for (unsigned axis = 0; axis < 3; axis++) {
      CPose3D guess(1, 2, 3, 0.4, 0, 0);
      guess.m_coords[axis] = far;
      EXPECT_THROW(Prior::near(guess), std::exception) << far;
      EXPECT_THROW(Prior::gaussian(CPose3DPDFGaussian(guess)), std::exception) << far;
    }
  EXPECT_NO_THROW(Prior::near(CPose3D(5e6, -4e6, 100, 1, 0, 0))) << "a place on the earth";
}

}  // namespace
}  // namespace mrpt::fusion::test::poses_test
