// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the poses of a run as files. */
#include "fusion_report/pose_graph.h"

#include <gtest/gtest.h>
#include <mrpt/fusion/poses.h>

#include <sstream>

#include "fusion_core/registration/perturbations.h"

namespace mrpt::fusion::test::pose_graph_test {
namespace {

Eigen::Isometry3d somePose() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(Eigen::Vector3d(31.25, -2, 0.5));
  T.rotate(Eigen::AngleAxisd(2.5, Eigen::Vector3d(0.1, -0.2, 1).normalized()));
  return T;
}

Matrix6d someCovariance() {
  Matrix6d A;
  for (int row = 0; row < 6; row++)
    for (int col = 0; col < 6; col++) A(row, col) = 0.01 * (row == col ? 3 : (row + 2 * col) % 3);
  return A * A.transpose();
}

FusionMember member(const std::string& robot, bool joined) {
  FusionMember m;
  m.robot = robot;
  m.joined = joined;
  return m;
}

/** Three robots; the second is not placed. */
Report teamReport() {
  Report report;
  report.members = {member("a", true), member("b", false), member("c\n: \"d\"", true)};
  FusionMember& c = report.members[2];
  c.pose = {toPose(somePose()),
            mrpt::math::CMatrixDouble66(toYawPitchRollCovariance(someCovariance(), somePose()))};
  c.links = {{0, somePose(), someCovariance()}, {1, somePose(), someCovariance()}};
  return report;
}

std::vector<std::string> linesOf(const std::string& text, const std::string& key) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (line.rfind(key, 0) == 0) lines.push_back(line.substr(key.size()));
  return lines;
}

TEST(PoseGraph, HoldsPlacedRobotsAndTheMatchesBetweenThem) {
  const PoseGraph graph = poseGraphOf(teamReport(), true);
  ASSERT_EQ(graph.vertices.size(), 2U);
  EXPECT_EQ(graph.vertices[0].id, 0U);
  EXPECT_EQ(graph.vertices[1].id, 2U);
  EXPECT_TRUE(graph.vertices[1].pose.isApprox(somePose(), 1e-12));
  EXPECT_TRUE(graph.vertices[1].covariance.isApprox(someCovariance(), 1e-9));
  ASSERT_EQ(graph.edges.size(), 1U) << "the link with b is left out";
  EXPECT_EQ(graph.edges[0].a, 0U);
  EXPECT_EQ(graph.edges[0].b, 2U);
}

TEST(PoseGraph, OfTwoMapsHoldsTheSecondIfBothAreMerged) {
  Report report;
  report.match.emplace();
  report.match->match.T_a_b = somePose();
  EXPECT_EQ(poseGraphOf(report, false).vertices.size(), 1U);
  const PoseGraph graph = poseGraphOf(report, true);
  ASSERT_EQ(graph.vertices.size(), 2U);
  EXPECT_EQ(graph.vertices[1].pose.matrix(), somePose().matrix());
  EXPECT_EQ(graph.edges.size(), 1U);
}

TEST(PoseGraph, G2oHasTheInformationOfARightPerturbation) {
  const std::string text = toG2o(poseGraphOf(teamReport(), true));
  EXPECT_EQ(linesOf(text, "VERTEX_SE3:QUAT ").size(), 2U);
  EXPECT_EQ(linesOf(text, "FIX ").at(0), "0");
  std::istringstream edge(linesOf(text, "EDGE_SE3:QUAT 0 2 ").at(0));
  double x, y, z, qx, qy, qz, qw;
  edge >> x >> y >> z >> qx >> qy >> qz >> qw;
  EXPECT_EQ(x, 31.25);
  EXPECT_TRUE(
      Eigen::Quaterniond(qw, qx, qy, qz).toRotationMatrix().isApprox(somePose().linear(), 1e-12));
  Matrix6d information;
  for (int row = 0; row < 6; row++)
    for (int col = row; col < 6; col++) {
      edge >> information(row, col);
      information(col, row) = information(row, col);
    }
  EXPECT_TRUE(edge) << "21 numbers";
  // The same uncertainty, sampled: T exp(right) = exp(left) T.
  const Matrix6d left = toLeftCovariance(information.inverse(), somePose());
  EXPECT_TRUE(left.isApprox(someCovariance(), 1e-6));
}

TEST(PoseGraph, ARightPerturbationIsTheLeftPerturbationOfItsAdjoint) {
  Vector6d right;
  right << 1e-6, -2e-6, 3e-6, 2e-6, 1e-6, -1e-6;
  const auto small = [](const Vector6d& v) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = v.head<3>();
    T.linear() += skew(v.tail<3>());
    return T;
  };
  const Vector6d left = adjointOf(somePose()) * right;
  EXPECT_TRUE((somePose() * small(right)).isApprox(small(left) * somePose(), 1e-9));
  EXPECT_FALSE((somePose() * small(right)).isApprox(small(right) * somePose(), 1e-7));
}

TEST(PoseGraph, TumHasTheIndexAsTime) {
  const auto lines = linesOf(toTum(poseGraphOf(teamReport(), true)), "2 ");
  ASSERT_EQ(lines.size(), 1U);
  std::istringstream numbers(lines[0]);
  size_t n = 0;
  for (double number; numbers >> number;) n++;
  EXPECT_EQ(n, 7U);
}

TEST(PoseGraph, NamesOfRobotsBreakNoLine) {
  const PoseGraph graph = poseGraphOf(teamReport(), true);
  EXPECT_EQ(linesOf(toYaml(graph), "    robot: ").at(1), R"("c\n: \"d\"")");
  EXPECT_EQ(linesOf(toG2o(graph), ":").size(), 0U);
}

TEST(Poses, CovariancesOfAnglesConvertBack) {
  const Matrix6d ypr = toYawPitchRollCovariance(someCovariance(), somePose());
  EXPECT_TRUE(fromYawPitchRollCovariance(ypr, somePose()).isApprox(someCovariance(), 1e-9));
}

}  // namespace
}  // namespace mrpt::fusion::test::pose_graph_test
