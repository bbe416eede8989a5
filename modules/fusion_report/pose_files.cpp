// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Writes the poses of a run as g2o, TUM and YAML. */

#include <charconv>

#include "fusion_base/printable.h"
#include "fusion_core/registration/perturbations.h"
#include "fusion_report/pose_graph.h"
#include "fusion_report/quoted.h"

namespace mrpt::fusion {
namespace {

/** Returns the shortest text that gives the same number again. */
std::string textOf(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof(text), number + 0.).ptr};
}

Eigen::Quaterniond rotationOf(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(T.linear()).normalized();
  return q.w() < 0 ? Eigen::Quaterniond(-q.coeffs()) : q;
}

/** Returns "x y z qx qy qz qw". */
std::string poseNumbers(const Eigen::Isometry3d& T, const char* separator = " ") {
  std::string text;
  const Eigen::Quaterniond q = rotationOf(T);
  for (const double v :
       {T.translation().x(), T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(), q.w()})
    text += (text.empty() ? "" : separator) + textOf(v);
  return text;
}

std::string yamlMatrix(const Matrix6d& m) {
  std::string text = "[";
  for (int row = 0; row < 6; row++) {
    text += row == 0 ? "[" : ", [";
    for (int col = 0; col < 6; col++) text += (col == 0 ? "" : ", ") + textOf(m(row, col));
    text += "]";
  }
  return text + "]";
}

std::string yamlPose(const Eigen::Isometry3d& T, const Matrix6d& covariance,
                     const std::string& indent) {
  const Eigen::Vector3d p = T.translation();
  const Eigen::Quaterniond q = rotationOf(T);
  return indent + "position: [" + textOf(p.x()) + ", " + textOf(p.y()) + ", " + textOf(p.z()) +
         "]\n" + indent + "quaternion: [" + textOf(q.x()) + ", " + textOf(q.y()) + ", " +
         textOf(q.z()) + ", " + textOf(q.w()) + "]\n" + indent +
         "covariance: " + yamlMatrix(covariance) + "\n";
}

}  // namespace

std::string toG2o(const PoseGraph& graph) {
  std::string text = "# poses of maps in the frame of the first map, m\n";
  for (const PoseVertex& v : graph.vertices) {
    const std::string id = std::to_string(v.id);
    text += "# " + id + " is " + printable(v.robot) + "\n";
    text += "VERTEX_SE3:QUAT " + id + " " + poseNumbers(v.pose) + "\n";
  }
  if (!graph.vertices.empty()) text += "FIX " + std::to_string(graph.vertices[0].id) + "\n";
  for (const PoseEdge& e : graph.edges) {
    text += "EDGE_SE3:QUAT " + std::to_string(e.a) + " " + std::to_string(e.b) + " " +
            poseNumbers(e.T_a_b);
    const Matrix6d information = informationOf(toRightCovariance(e.covariance, e.T_a_b));
    for (int row = 0; row < 6; row++)
      for (int col = row; col < 6; col++) text += " " + textOf(information(row, col));
    text += "\n";
  }
  return text;
}

std::string toTum(const PoseGraph& graph) {
  std::string text = "# time x y z qx qy qz qw; the time is the index of the map, from 0\n";
  for (const PoseVertex& v : graph.vertices)
    text += std::to_string(v.id) + " " + poseNumbers(v.pose) + "\n";
  return text;
}

std::string toYaml(const PoseGraph& graph) {
  std::string text =
      "# Poses in the frame of the first map, m. quaternion: x, y, z, w. covariance: of a small\n"
      "# translation (m) and rotation (rad) that are applied after the pose.\n"
      "robots:\n";
  for (const PoseVertex& v : graph.vertices)
    text += "  - id: " + std::to_string(v.id) + "\n    robot: " + quoted(v.robot) + "\n" +
            yamlPose(v.pose, v.covariance, "    ");
  text += graph.edges.empty() ? "matches: []\n" : "matches:\n";
  for (const PoseEdge& e : graph.edges)
    text += "  - a: " + std::to_string(e.a) + "\n    b: " + std::to_string(e.b) + "\n" +
            yamlPose(e.T_a_b, e.covariance, "    ");
  return text;
}

}  // namespace mrpt::fusion
