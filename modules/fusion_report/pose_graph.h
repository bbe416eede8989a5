// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fusion_report/report.h"

/** \file
 * The poses of the placed robots as a graph, and the graph as text for other programs. */

namespace mrpt::fusion {

/** A placed robot. */
struct PoseVertex {
  size_t id = 0;                                           ///< Index of the robot in the input
  std::string robot;                                       ///< Name of the robot
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< Pose in the frame of the fused map
  Matrix6d covariance = Matrix6d::Zero();                  ///< See MatchResult::covariance
};

/** A match that holds two robots together. */
struct PoseEdge {
  size_t a = 0;                                             ///< Id of the robot with map A
  size_t b = 0;                                             ///< Id of the robot with map B
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< Measured pose of map B in A's frame
  Matrix6d covariance = Matrix6d::Identity();               ///< See MatchResult::covariance
};

/** The poses of a run. */
struct PoseGraph {
  std::vector<PoseVertex> vertices;  ///< Placed robots, in the order of the input
  std::vector<PoseEdge> edges;       ///< Matches between placed robots
};

/** Returns the placed robots of a report: the robots whose maps are in the fused map, and the first
 * robot. \param[in] report A report on `fuse`. \param[in] is_merged For two maps: true if both are
 * merged. */
PoseGraph poseGraphOf(const Report& report, bool is_merged);

/** Returns the inverse of a covariance, symmetric to the last bit. */
Matrix6d informationOf(const Matrix6d& covariance);

/** Returns a g2o file: VERTEX_SE3:QUAT, FIX for the first robot, EDGE_SE3:QUAT. The information is
 * the inverse of the covariance of a right perturbation (translation, rotation), m and rad. GTSAM
 * and Ceres' example read it so; g2o itself takes halves of angles and weighs rotations 0.25 times
 * as much. */
std::string toG2o(const PoseGraph& graph);
/** Returns a TUM trajectory: `time x y z qx qy qz qw`. The time is the index of the robot. */
std::string toTum(const PoseGraph& graph);
/** Returns YAML with names, poses, covariances and matches. */
std::string toYaml(const PoseGraph& graph);

}  // namespace mrpt::fusion
