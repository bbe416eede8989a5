// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/map/eigen_solvers.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

namespace mrpt::fusion::test::eigen_solvers_test {
namespace {

template <int N>
void expectEigenvectors() {
  std::mt19937 random(N);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 100; trial++) {
    const auto m = [&] {
      const auto half = Eigen::Matrix<double, N, N>::NullaryExpr([&] { return normal(random); });
      const Eigen::Matrix<double, N, N> filled = half;
      return Eigen::Matrix<double, N, N>(filled + filled.transpose());
    }();
    const SymmetricEigen<N> s(m);
    for (int i = 0; i < N; i++) {
      const auto v = s.eigenvectors.col(i);
      EXPECT_NEAR(v.norm(), 1, 1e-12);
      EXPECT_LT((m * v - s.eigenvalues[i] * v).norm(), 1e-12 * N * m.norm());
      if (i > 0) {
        EXPECT_GE(s.eigenvalues[i], s.eigenvalues[i - 1]);
        EXPECT_NEAR(v.dot(s.eigenvectors.col(i - 1)), 0, 1e-12);
      }
    }
  }
}

TEST(EigenSolvers, SymmetricMatrices) {
  expectEigenvectors<2>();
  expectEigenvectors<3>();
  expectEigenvectors<6>();
  expectEigenvectors<7>();
}

TEST(EigenSolvers, RotationBetweenTurnsOneDirectionToTheOther) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto direction = [&] {
    return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
  };
  for (int trial = 0; trial < 100; trial++) {
    const Eigen::Vector3d from = direction(),
                          to = trial % 10 == 0 ? Eigen::Vector3d(-from) : direction();
    const Eigen::Matrix3d R = rotationBetween(from, to);
    EXPECT_LT((R * from - to).norm(), 1e-7);
    EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(R.trace(), 1 + 2 * from.dot(to), 1e-7);  // no turn beyond the angle between them
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::eigen_solvers_test
