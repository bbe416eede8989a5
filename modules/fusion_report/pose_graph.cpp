// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Collects the poses of a run. */

#include "fusion_report/pose_graph.h"

#include <mrpt/fusion/poses.h>

#include <Eigen/LU>
#include <set>

namespace mrpt::fusion {

Matrix6d informationOf(const Matrix6d& covariance) {
  const Matrix6d inverse = covariance.inverse();
  return 0.5 * (inverse + inverse.transpose());
}

PoseGraph poseGraphOf(const Report& report, bool is_merged) {
  PoseGraph graph;
  if (report.members.empty()) {
    const auto nameOf = [&](size_t i) {
      return i < report.maps.size() ? report.maps[i].path : std::string();
    };
    graph.vertices.push_back({0, nameOf(0)});
    if (is_merged && report.match) {
      const MatchResult& match = report.match->match;
      graph.vertices.push_back({1, nameOf(1), match.T_a_b, match.covariance});
      graph.edges.push_back({0, 1, match.T_a_b, match.covariance});
    }
    return graph;
  }
  std::set<size_t> placed;
  for (size_t k = 0; k < report.members.size(); k++) {
    const FusionMember& m = report.members[k];
    if (!m.joined) continue;
    placed.insert(k);
    const Eigen::Isometry3d pose = toEigen(m.pose.mean);
    graph.vertices.push_back(
        {k, m.robot, pose, fromYawPitchRollCovariance(m.pose.cov.asEigen(), pose)});
  }
  for (const PoseVertex& v : graph.vertices)
    for (const FusionLink& link : report.members[v.id].links)
      if (placed.count(link.with))
        graph.edges.push_back({link.with, v.id, link.T_a_b, link.covariance});
  return graph;
}

}  // namespace mrpt::fusion
