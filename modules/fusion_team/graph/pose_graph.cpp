// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Optimises the poses of a team with Ceres. */
#include "fusion_team/graph/pose_graph.h"

#include <ceres/ceres.h>

namespace mrpt::fusion {
namespace {

/** A pose as Ceres changes it. */
struct Parameters {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d position;
};

/** Difference of the pose of b in a's frame from the measured pose, in standard deviations. */
struct Residual {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d position;
  double per_metre, per_radian;

  template <class T>
  bool operator()(const T* q_a, const T* p_a, const T* q_b, const T* p_b, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> rotation_a(q_a), rotation_b(q_b);
    const Eigen::Map<const Vector> position_a(p_a), position_b(p_b);
    const Eigen::Quaternion<T> in_a = rotation_a.conjugate() * rotation_b;
    const Vector p_in_a = rotation_a.conjugate() * (position_b - position_a);
    const Eigen::Quaternion<T> difference = rotation.cast<T>().conjugate() * in_a;
    Eigen::Map<Vector> of_position(residual), of_rotation(residual + 3);
    of_position = T(per_metre) * (p_in_a - position.cast<T>());
    of_rotation = T(2 * per_radian) * difference.vec();
    return true;
  }
};

}  // namespace

void optimizePoses(const std::vector<PoseConstraint>& constraints,
                   std::vector<std::optional<Eigen::Isometry3d>>& pose) {
  if (constraints.empty()) return;
  std::vector<Parameters> parameters(pose.size());
  for (size_t k = 0; k < pose.size(); k++)
    if (pose[k])
      parameters[k] = {Eigen::Quaterniond(pose[k]->linear()).normalized(), pose[k]->translation()};

  ceres::EigenQuaternionManifold quaternions;
  ceres::Problem::Options options;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  std::vector<bool> is_used(pose.size());
  for (const PoseConstraint& c : constraints) {
    Parameters &a = parameters[c.a], &b = parameters[c.b];
    auto* cost = new ceres::AutoDiffCostFunction<Residual, 6, 4, 3, 4, 3>(
        new Residual{Eigen::Quaterniond(c.T_a_b.linear()).normalized(), c.T_a_b.translation(),
                     1 / c.sigma_translation, 1 / c.sigma_rotation});
    problem.AddResidualBlock(cost, new ceres::CauchyLoss(1.0), a.rotation.coeffs().data(),
                             a.position.data(), b.rotation.coeffs().data(), b.position.data());
    for (const size_t k : {c.a, c.b}) {
      if (is_used[k]) continue;
      is_used[k] = true;
      problem.SetManifold(parameters[k].rotation.coeffs().data(), &quaternions);
    }
  }
  for (size_t k = 0; k < pose.size(); k++)
    if (is_used[k]) {
      problem.SetParameterBlockConstant(parameters[k].rotation.coeffs().data());
      problem.SetParameterBlockConstant(parameters[k].position.data());
      break;
    }
  ceres::Solver::Options solving;
  solving.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solving.num_threads = 1;
  solving.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solving, &problem, &summary);
  if (!summary.IsSolutionUsable()) return;
  for (size_t k = 0; k < pose.size(); k++)
    if (is_used[k]) {
      pose[k]->linear() = parameters[k].rotation.normalized().toRotationMatrix();
      pose[k]->translation() = parameters[k].position;
    }
}

}  // namespace mrpt::fusion
