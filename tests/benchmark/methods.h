// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "map_pair.h"

/** \file The methods that are compared, each behind the same two calls. */

namespace mrpt::fusion::benchmark {

/** The paper's protocol (Sec. VI-C) for the methods that have one gate and one level. */
constexpr double kGate = 2.0;  ///< largest distance of a pair, m
constexpr unsigned kMaxIterations = 30;

struct Registration {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
  unsigned iterations = 0;
  std::optional<bool> accepted;  ///< the method's own verdict, if it gives one
  double probability = 0;        ///< of being right, as the method has it
  /** Evidence of the verdict, if the method gives one; each in [0,1]. */
  double overlap = 0, conflict_ratio = 0, runner_up = 0, inlier_ratio = 0;
  double rival_support = 0;    ///< obstacles that the rival confirms, over those of the pose
  double rival_same_side = 0;  ///< the same of obstacles that both maps see from the same side
  double missed_ratio = 0;     ///< of obstacles compared with a map without free space
  double without_free = 0;     ///< share of the maps that have no free space: 0, 0.5 or 1
  double scale = 1;            ///< factor of the lengths of the settings
  double size_ratio = 1;       ///< size of map B over the size of map A
  /** Of a left perturbation (translation, rotation), if the method gives one. */
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;
};

class Method {
 public:
  virtual ~Method() = default;
  /** All that depends on the maps alone; they outlive the method. */
  virtual void prepare(const MapPair& pair) = 0;
  /** Does what the method would leave to its first alignment, so that it is not in that one's time.
   */
  virtual void warmUp(const MapPair&) {}
  /** From a start to a result, verdict included. */
  virtual Registration align(const Eigen::Isometry3d& start) = 0;
};

/** "icp", "icp_plane", "gicp" or "ndt": PCL's.
 * \exception std::invalid_argument For any other name. */
std::unique_ptr<Method> makePclMethod(const std::string& name);

/** PCL's point-to-point ICP between two sets of points (m), one iteration at a time.
 * \return The pose after each iteration, at most \a iterations. */
std::vector<Eigen::Isometry3d> icpSteps(const std::vector<Eigen::Vector3f>& model,
                                        const std::vector<Eigen::Vector3f>& scene,
                                        const Eigen::Isometry3d& start, double gate,
                                        unsigned iterations);

}  // namespace mrpt::fusion::benchmark
