// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the covariance of errors that all pairs have in common. */
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "fusion_core/map/map_voxels.h"
#include "fusion_core/registration/normal_equations.h"
#include "fusion_core/registration/pose_covariance.h"

namespace mrpt::fusion::test::common_covariance_test {
namespace {

using Eigen::Vector3d;

/** Points of a cube of 8 m about (20, -5, 1). */
std::vector<Eigen::Vector3f> cube() {
  std::vector<Eigen::Vector3f> points;
  for (int x = -4; x <= 4; x++)
    for (int y = -4; y <= 4; y++)
      for (int z = -4; z <= 4; z++)
        points.emplace_back(20.F + float(x), -5.F + float(y), 1.F + float(z));
  return points;
}

TEST(CommonCovariance, IsThatOfFitsToShiftedAndBentPoints) {
  constexpr double kShift = 0.03 * 0.03, kBend = 0.02 * 0.02;
  constexpr int kTrials = 2000;
  const auto points = cube();
  const Vector3d centre = meanOf(points);
  double squares = 0;
  for (const auto& p : points) squares += (p.cast<double>() - centre).squaredNorm();
  const double at_rms = std::sqrt(kBend * static_cast<double>(points.size()) / squares);
  // Normal equations of the small step that moves the points as the errors move them.
  Matrix6d H = Matrix6d::Zero();
  for (const auto& p : points) {
    Eigen::Matrix<double, 3, 6> J;
    J << Eigen::Matrix3d::Identity(), -skew(p.cast<double>());
    H += J.transpose() * J;
  }
  const auto solver = H.ldlt();
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  Matrix6d spread = Matrix6d::Zero();
  for (int trial = 0; trial < kTrials; trial++) {
    const Vector3d shift =
        std::sqrt(kShift) * Vector3d::NullaryExpr([&] { return normal(generator); });
    const Eigen::Matrix3d G =
        at_rms * Eigen::Matrix3d::NullaryExpr([&] { return normal(generator); });
    Vector6d g = Vector6d::Zero();
    for (const auto& q : points) {
      const Vector3d p = q.cast<double>(), u = shift + G * (p - centre);
      g.head<3>() += u;
      g.tail<3>() += p.cross(u);
    }
    const Vector6d xi = solver.solve(g);
    spread += xi * xi.transpose() / kTrials;
  }
  const Matrix6d stated = commonCovariance(points, kShift, kBend, centre);
  EXPECT_NEAR((stated.inverse() * spread).trace() / 6, 1, 0.1);
  EXPECT_NEAR((spread.inverse() * stated).trace() / 6, 1, 0.1);
}

TEST(CommonCovariance, IsFiniteForPointsAtOnePlace) {
  EXPECT_TRUE(commonCovariance({{1, 2, 3}, {1, 2, 3}}, 1e-4, 1e-4, {1, 2, 3}).allFinite());
  EXPECT_TRUE(commonCovariance({}, 1e-4, 1e-4, Vector3d::Zero()).allFinite());
}

}  // namespace
}  // namespace mrpt::fusion::test::common_covariance_test
