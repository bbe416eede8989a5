// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_team/graph/pose_graph.h"

#include <gtest/gtest.h>
#include <mrpt/fusion/poses.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "fusion_core/registration/normal_equations.h"
#include "fusion_core/registration/perturbations.h"

namespace mrpt::fusion::test::pose_graph_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Poses = std::vector<std::optional<Isometry3d>>;

Isometry3d at(const Vector3d& position, double yaw, double pitch = 0) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() = position;
  T.linear() =
      (Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Vector3d::UnitY()))
          .matrix();
  return T;
}

/** A covariance with correlations: 2 cm to 5 cm, and a fraction of a degree. */
Matrix6d someCovariance(double size = 1) {
  Matrix6d A = Matrix6d::Zero();
  A.diagonal() << 0.02, 0.03, 0.05, 0.001, 0.002, 0.004;
  A(1, 0) = 0.01;
  A(5, 1) = 0.002;
  A(3, 2) = -0.0005;
  return size * A * A.transpose();
}

Isometry3d perturbed(const Isometry3d& T, const Vector6d& xi) {
  Isometry3d moved = Isometry3d::Identity();
  const Vector3d w = xi.tail<3>();
  moved.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()).matrix();
  moved.translation() = xi.head<3>();
  return moved * T;
}

Vector6d errorOf(const Isometry3d& T, const Isometry3d& truth) {
  const Isometry3d off = T * truth.inverse();
  const Eigen::AngleAxisd turn(off.linear());
  Vector6d xi;
  xi << off.translation(), turn.angle() * turn.axis();
  return xi;
}

/** True poses of a ring of maps, the first at the origin. */
std::vector<Isometry3d> ringOf(size_t n) {
  std::vector<Isometry3d> ring;
  for (size_t k = 0; k < n; k++) {
    const double angle = 2 * M_PI * static_cast<double>(k) / static_cast<double>(n);
    ring.push_back(at({20 * std::cos(angle) - 20, 20 * std::sin(angle), 0.1 * angle}, 2 * angle));
  }
  return ring;
}

/** Measures each map of a ring from the maps before, with errors of someCovariance(). */
std::vector<PoseConstraint> measured(const std::vector<Isometry3d>& ring, size_t before,
                                     double stated, std::mt19937& generator) {
  std::normal_distribution<double> normal;
  const Matrix6d L = someCovariance().llt().matrixL();
  std::vector<PoseConstraint> constraints;
  for (size_t a = 0; a < ring.size(); a++)
    for (size_t step = 1; step <= before; step++) {
      const size_t b = (a + step) % ring.size();
      Vector6d error;
      for (int i = 0; i < 6; i++) error[i] = normal(generator);
      const Isometry3d T = perturbed(ring[a].inverse() * ring[b], L * error);
      constraints.push_back(constraintOf(a, b, T, someCovariance(stated)));
    }
  return constraints;
}

/** Returns the mean NEES of the maps of rings, measured often. \a stated is the factor of the
 * stated covariance. */
double meanNees(size_t before, double stated) {
  constexpr size_t kRings = 60, kMaps = 6;
  std::mt19937 generator(7);
  const std::vector<Isometry3d> truth = ringOf(kMaps);
  double sum = 0;
  for (size_t i = 0; i < kRings; i++) {
    Poses poses(truth.begin(), truth.end());
    const auto covariances =
        optimizeWithCovariance(measured(truth, before, stated, generator), poses);
    for (size_t k = 1; k < kMaps; k++) {
      const Vector6d error = errorOf(*poses[k], truth[k]);
      sum += error.dot(covariances[k].ldlt().solve(error));
    }
  }
  return sum / (kRings * (kMaps - 1));
}

TEST(JointCovariance, OfAChainIsThatOfComposedPoses) {
  const Isometry3d T_0_1 = at({5, -3, 1}, 2, 0.3), T_1_2 = at({-8, 4, 0.5}, -1, -0.2);
  Poses poses{Isometry3d::Identity(), T_0_1, T_0_1 * T_1_2};
  const auto covariances = optimizeWithCovariance(
      {constraintOf(0, 1, T_0_1, someCovariance()), constraintOf(1, 2, T_1_2, someCovariance(2))},
      poses);
  EXPECT_TRUE(poses[2]->isApprox(T_0_1 * T_1_2, 1e-9));
  EXPECT_TRUE(covariances[0].isZero(0));
  EXPECT_TRUE(covariances[1].isApprox(someCovariance(), 1e-6)) << covariances[1];
  // A left perturbation of T_1_2 is one of T_0_2, seen from frame 0.
  const Matrix6d adjoint = adjointOf(T_0_1);
  const Matrix6d expected = someCovariance() + adjoint * someCovariance(2) * adjoint.transpose();
  EXPECT_TRUE(covariances[2].isApprox(expected, 1e-6)) << covariances[2] << "\n\n" << expected;
}

TEST(JointCovariance, TwoEqualMeasurementsHalveIt) {
  const Isometry3d T = at({5, -3, 1}, 2, 0.3);
  Poses poses{Isometry3d::Identity(), T};
  const PoseConstraint once = constraintOf(0, 1, T, someCovariance());
  const auto covariances = optimizeWithCovariance({once, once}, poses);
  EXPECT_TRUE(covariances[1].isApprox(0.5 * someCovariance(), 1e-6)) << covariances[1];
}

TEST(JointCovariance, TheDirectionOfAConstraintDoesNotMatter) {
  const Isometry3d T = at({5, -3, 1}, 2, 0.3);
  Poses forward{Isometry3d::Identity(), T}, backward = forward;
  const auto of_forward =
      optimizeWithCovariance({constraintOf(0, 1, T, someCovariance())}, forward);
  const auto of_backward = optimizeWithCovariance(
      {constraintOf(1, 0, T.inverse(), toRightCovariance(someCovariance(), T))}, backward);
  EXPECT_TRUE(of_backward[1].isApprox(of_forward[1], 1e-6));
}

TEST(JointCovariance, IsConsistentOnRings) {
  // The standard deviation of the mean is about 0.3. Loops may enlarge the covariance by chance.
  for (const size_t before : {1U, 2U}) {
    const double nees = meanNees(before, 1);
    EXPECT_GT(nees, 4) << before;
    EXPECT_LT(nees, 6.9) << before;
  }
}

TEST(JointCovariance, GrowsIfLoopsDoNotCloseAsTheCovariancesSay) {
  const double nees = meanNees(2, 1. / 25);
  EXPECT_LT(nees, 25 * 6 / 5.) << "the loops show that the constraints are less exact";
  EXPECT_GT(nees, 3) << "the covariance does not grow more than that";
}

TEST(JointCovariance, AConstraintThatSlidesLeavesADirectionUnknown) {
  Matrix6d slides = someCovariance();
  slides(0, 0) = kUnknownVariance;
  const Isometry3d T = at({5, -3, 1}, 0);
  Poses poses{Isometry3d::Identity(), T};
  const auto covariances = optimizeWithCovariance({constraintOf(0, 1, T, slides)}, poses);
  EXPECT_NEAR(covariances[1](0, 0), kUnknownVariance, 0.01 * kUnknownVariance);
  EXPECT_NEAR(covariances[1](1, 1), slides(1, 1), 1e-3 * slides(1, 1));
}

TEST(JointCovariance, AWrongLoopMovesThePosesLittle) {
  const std::vector<Isometry3d> truth = ringOf(6);
  Poses poses(truth.begin(), truth.end());
  std::vector<PoseConstraint> constraints;
  for (size_t k = 0; k < 6; k++)
    for (size_t step = 1; step <= 2; step++)
      constraints.push_back(constraintOf(
          k, (k + step) % 6, truth[k].inverse() * truth[(k + step) % 6], someCovariance()));
  constraints.push_back(
      constraintOf(0, 3, at({0.5, 0, 0}, 0) * truth[0].inverse() * truth[3], someCovariance()));
  optimizeWithCovariance(constraints, poses);
  for (size_t k = 1; k < 6; k++)
    EXPECT_LT((poses[k]->translation() - truth[k].translation()).norm(), 0.05) << k;
}

TEST(PoseGraph, OfEachPartTheFirstMapKeepsItsPose) {
  const Isometry3d beside = at({10, 0, 0}, 0);
  Poses pose{at({0, 0, 0}, 0), at({5, 7, 0}, 1), at({9, 0, 0}, 0), at({5, 18, 0}, 1)};
  const Isometry3d first_of_second = *pose[1];
  optimizePoses({{0, 2, beside}, {1, 3, beside}}, pose);
  EXPECT_TRUE(pose[0]->isApprox(at({0, 0, 0}, 0), 0));
  EXPECT_TRUE(pose[1]->isApprox(first_of_second, 1e-12));
  EXPECT_TRUE(pose[2]->isApprox(beside, 1e-6));
  EXPECT_TRUE(pose[3]->isApprox(first_of_second * beside, 1e-6));
}

}  // namespace
}  // namespace mrpt::fusion::test::pose_graph_test
