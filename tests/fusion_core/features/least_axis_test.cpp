// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the least eigenvalue and its eigenvector, against Eigen's solver. */
#include "fusion_core/features/least_axis.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>
#include <vector>

namespace mrpt::fusion::test::least_axis_test {
namespace {

/** A symmetric matrix of these eigenvalues, turned at random. */
Eigen::Matrix3d matrixOf(const Eigen::Vector3d& eigenvalues, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Eigen::Matrix3d R =
      Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
          .normalized()
          .toRotationMatrix();
  const Eigen::Matrix3d m = R * eigenvalues.asDiagonal() * R.transpose();
  return 0.5 * (m + m.transpose());
}

/** Eigenvalues of planes, lines, solids and what lies between them, in small units and large. */
std::vector<Eigen::Vector3d> manyEigenvalues(std::mt19937& random) {
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Eigen::Vector3d> all;
  for (const double unit : {1e-4, 1.0, 1e4}) {
    for (int i = 0; i < 500; i++)
      all.push_back(unit * Eigen::Vector3d(share(random), share(random), share(random)));
    for (const double least : {0.0, 1e-9, 1e-3, 0.2})
      for (const double middle : {0.25, 0.5, 1.0})
        all.push_back(unit * Eigen::Vector3d(least, middle, 1));
  }
  return all;
}

TEST(LeastAxis, ValueIsTheLeastOfEigensSolver) {
  std::mt19937 random(1);
  for (const Eigen::Vector3d& eigenvalues : manyEigenvalues(random)) {
    const Eigen::Matrix3d m = matrixOf(eigenvalues, random);
    const LeastAxis least(m);
    const auto expected = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m).eigenvalues();
    EXPECT_NEAR(least.value(), expected[0], 1e-6 * m.trace()) << eigenvalues.transpose();
    EXPECT_GE(least.value(), 0);
    EXPECT_DOUBLE_EQ(least.trace(), m.trace());
  }
}

TEST(LeastAxis, DirectionIsThatOfEigensSolver) {
  std::mt19937 random(2);
  int clear = 0;
  for (const Eigen::Vector3d& eigenvalues : manyEigenvalues(random)) {
    const Eigen::Matrix3d m = matrixOf(eigenvalues, random);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(m);
    const Eigen::Vector3d direction = LeastAxis(m).direction();
    EXPECT_NEAR(direction.norm(), 1, 1e-9);
    if (solver.eigenvalues()[1] - solver.eigenvalues()[0] < 0.01 * m.trace()) continue;
    clear++;
    EXPECT_NEAR(std::abs(direction.dot(solver.eigenvectors().col(0))), 1, 1e-6)
        << eigenvalues.transpose();
  }
  EXPECT_GT(clear, 1000);
}

TEST(LeastAxis, TellsWhetherTheOthersExceedALimit) {
  std::mt19937 random(3);
  int exceed = 0, compared = 0;
  for (const Eigen::Vector3d& eigenvalues : manyEigenvalues(random)) {
    const Eigen::Matrix3d m = matrixOf(eigenvalues, random);
    const double second = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m).eigenvalues()[1];
    for (const double share : {0.1, 0.2, 0.3, 0.4}) {
      const double limit = share * m.trace();
      if (std::abs(second - limit) < 1e-5 * m.trace()) continue;  // too near to tell
      compared++;
      exceed += second > limit;
      EXPECT_EQ(LeastAxis(m).othersExceed(limit), second > limit) << eigenvalues.transpose();
    }
  }
  EXPECT_GT(exceed, compared / 10);
  EXPECT_LT(exceed, compared * 9 / 10);
}

TEST(LeastAxis, OfALineIsAcrossIt) {
  std::mt19937 random(4);
  for (int i = 0; i < 100; i++) {
    const Eigen::Matrix3d line = matrixOf({0, 0, 2}, random);
    const LeastAxis least(line);
    EXPECT_NEAR(least.value(), 0, 1e-6);
    EXPECT_NEAR(least.direction().norm(), 1, 1e-9);
    EXPECT_NEAR((line * least.direction()).norm(), 0, 1e-5);
    EXPECT_FALSE(least.othersExceed(1e-3));
  }
}

TEST(LeastAxis, OfABallIsAnyDirection) {
  const LeastAxis least(3 * Eigen::Matrix3d::Identity());
  EXPECT_NEAR(least.value(), 3, 1e-4) << "a triple root is found slowly";
  EXPECT_NEAR(least.direction().norm(), 1, 1e-9);
}

TEST(LeastAxis, OfNothingIsStillADirection) {
  const LeastAxis least(Eigen::Matrix3d::Zero());
  EXPECT_EQ(least.value(), 0);
  EXPECT_NEAR(least.direction().norm(), 1, 1e-12);
  EXPECT_FALSE(least.othersExceed(0));
}

}  // namespace
}  // namespace mrpt::fusion::test::least_axis_test
