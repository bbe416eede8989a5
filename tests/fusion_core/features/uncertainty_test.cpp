// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/features/uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <random>

#include "fusion_core/map/eigen_solvers.h"

namespace mrpt::fusion::test::uncertainty_test {
namespace {

using Points = std::vector<Eigen::Vector3f>;

// ---------------------------------------------------------------- eq. (4)

TEST(VoxelVariance, PlainIsTheInverseProbabilityWhateverTheVoxelSize) {
  EXPECT_DOUBLE_EQ(voxelVariance(0.5, 0.1, VoxelCovariance::Plain), 2.0);
  EXPECT_DOUBLE_EQ(voxelVariance(0.8, 0.1, VoxelCovariance::Plain), 1.25);
  EXPECT_DOUBLE_EQ(voxelVariance(0.8, 2.0, VoxelCovariance::Plain), 1.25);
}

TEST(VoxelVariance, QuantisationIsThatOfAUniformPositionOverTheProbability) {
  EXPECT_DOUBLE_EQ(voxelVariance(1.0, 0.6, VoxelCovariance::Quantisation), 0.03);
  EXPECT_DOUBLE_EQ(voxelVariance(0.5, 0.6, VoxelCovariance::Quantisation), 0.06);
}

TEST(VoxelVariance, StaysFiniteAtProbabilityZero) {
  EXPECT_TRUE(std::isfinite(voxelVariance(0, 0.1, VoxelCovariance::Plain)));
  EXPECT_GT(voxelVariance(0, 0.1, VoxelCovariance::Plain), 1e3);
}

// ---------------------------------------------------------------- eq. (6)

TEST(EdgeCovariance, OfALineHasAllItsVarianceAlongIt) {
  // Mean 2, variance (4 + 1 + 0 + 1 + 4) / 5 = 2 along y.
  const EdgeCovariance c =
      edgeCovariance(Points{{1, 0, 3}, {1, 1, 3}, {1, 2, 3}, {1, 3, 3}, {1, 4, 3}});
  EXPECT_NEAR(c.eigenvalues[0], 0, 1e-12);
  EXPECT_NEAR(c.eigenvalues[1], 0, 1e-12);
  EXPECT_NEAR(c.eigenvalues[2], 2, 1e-12);
  EXPECT_NEAR(std::abs(c.direction().y()), 1, 1e-12);
  EXPECT_NEAR(c.linearity(), 1, 1e-12);
}

TEST(EdgeCovariance, OfARectangleSeesItsTwoSides) {
  // Variance 4 along x, 1 along z, none along y.
  const EdgeCovariance c = edgeCovariance(Points{{2, 5, 1}, {2, 5, -1}, {-2, 5, 1}, {-2, 5, -1}});
  EXPECT_TRUE(c.eigenvalues.isApprox(Eigen::Vector3d(0, 1, 4), 1e-12));
  EXPECT_NEAR(std::abs(c.direction().x()), 1, 1e-12);
  EXPECT_NEAR(c.linearity(), 0.8, 1e-12);
}

TEST(EdgeCovariance, OfABallHasNoDirection) {
  const EdgeCovariance c =
      edgeCovariance(Points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}});
  EXPECT_TRUE(c.eigenvalues.isApprox(Eigen::Vector3d::Constant(1.0 / 3), 1e-12));
  EXPECT_NEAR(c.linearity(), 1.0 / 3, 1e-12);
}

TEST(EdgeCovariance, EigenDecompositionGivesTheSampleCovarianceBack) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  Points points;
  for (int i = 0; i < 50; i++)
    points.emplace_back(3 + normal(random), 2 * normal(random), 0.5F * normal(random));

  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p.cast<double>() / 50;
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  for (const auto& p : points)
    expected += (p.cast<double>() - mean) * (p.cast<double>() - mean).transpose() / 50;

  const EdgeCovariance c = edgeCovariance(points);
  EXPECT_TRUE(c.matrix(0).isApprox(expected, 1e-9));
  EXPECT_TRUE(c.matrix(0.3).isApprox(expected + 0.3 * Eigen::Matrix3d::Identity(), 1e-9));
  EXPECT_LE(c.eigenvalues[0], c.eigenvalues[1]);
  EXPECT_LE(c.eigenvalues[1], c.eigenvalues[2]);
}

TEST(EdgeCovariance, TooFewOrCoincidentPointsTellNoDirection) {
  for (const Points& points : {Points{}, Points{{1, 2, 3}}, Points{{0, 0, 0}, {0, 0, 2}},
                               Points{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}}}) {
    const EdgeCovariance c = edgeCovariance(points);
    EXPECT_DOUBLE_EQ(c.linearity(), 1.0 / 3) << points.size() << " points";
    EXPECT_EQ(c.eigenvalues[0], c.eigenvalues[2]) << points.size() << " points";
    EXPECT_NEAR(c.direction().norm(), 1, 1e-12);
  }
  // Two points 2 m apart still spread: variance 1 in all, a third along each axis.
  EXPECT_DOUBLE_EQ(edgeCovariance(Points{{0, 0, 0}, {0, 0, 2}}).eigenvalues[0], 1.0 / 3);
}

// ---------------------------------------------------------------- eqs. (7)-(9)

Eigen::Matrix3d randomCovariance(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Eigen::Matrix3d a = Eigen::Matrix3d::NullaryExpr([&] { return normal(random); });
  return a * a.transpose() + 0.01 * Eigen::Matrix3d::Identity();
}

TEST(FuseCovariances, IsTheInverseOfTheSumOfTheInverses) {
  std::mt19937 random(2);
  for (const double v : {0.001, 0.05, 1.03, 40.0}) {
    const Eigen::Matrix3d edge = randomCovariance(random);
    const Eigen::Matrix3d expected = (Eigen::Matrix3d::Identity() / v + edge.inverse()).inverse();
    EXPECT_TRUE(fuseCovariances(v, edge).isApprox(expected, 1e-9)) << v;
  }
}

TEST(FuseCovariances, ByHandAlongEachAxis) {
  const Eigen::Matrix3d edge = Eigen::Vector3d(1, 2, 6).asDiagonal();
  const Eigen::Matrix3d fused = fuseCovariances(2, edge);
  EXPECT_TRUE(fused.diagonal().isApprox(Eigen::Vector3d(2.0 / 3, 1, 1.5), 1e-12));
}

TEST(FuseCovariances, IsSymmetricAndLessUncertainThanEither) {
  std::mt19937 random(3);
  for (int i = 0; i < 20; i++) {
    const Eigen::Matrix3d edge = randomCovariance(random);
    const Eigen::Matrix3d fused = fuseCovariances(0.7, edge);
    EXPECT_EQ(fused, fused.transpose());
    const auto least = [](const Eigen::Matrix3d& m) { return SymmetricEigen<3>(m).eigenvalues[0]; };
    EXPECT_GT(least(fused), 0);
    EXPECT_GT(least(edge - fused), -1e-9);
    EXPECT_GT(least(0.7 * Eigen::Matrix3d::Identity() - fused), -1e-9);
  }
}

TEST(FuseCovariances, SingularEdgeStaysSingularAcrossAndIsFusedAlong) {
  // A perfect line along (1,1,0): no extent across it, variance 3 along it.
  const Eigen::Vector3d tau = Eigen::Vector3d(1, 1, 0).normalized();
  const Eigen::Matrix3d fused = fuseCovariances(1.5, 3 * tau * tau.transpose());
  EXPECT_TRUE(fused.isApprox(1.0 * tau * tau.transpose(), 1e-12));
  EXPECT_TRUE(fuseCovariances(1.5, Eigen::Matrix3d::Zero()).isZero());
}

}  // namespace
}  // namespace mrpt::fusion::test::uncertainty_test
