// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Optimises the poses of a team with Ceres. */
#include "fusion_team/graph/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "fusion_core/registration/normal_equations.h"

namespace mrpt::fusion {
namespace {

/** 95 % of the squared errors of right constraints are below. */
constexpr double kSquaredBound = 12.6;

using Poses = std::vector<std::optional<Eigen::Isometry3d>>;

/** A pose as Ceres changes it. */
struct Parameters {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d position;
};

/** Difference of the pose of b in a's frame from the measured pose, with unit variance. */
struct Residual {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d position;
  Matrix6d whitening;

  template <class T>
  bool operator()(const T* q_a, const T* p_a, const T* q_b, const T* p_b, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> rotation_a(q_a), rotation_b(q_b);
    const Eigen::Map<const Vector> position_a(p_a), position_b(p_b);
    const Eigen::Quaternion<T> in_a = rotation_a.conjugate() * rotation_b;
    const Vector p_in_a = rotation_a.conjugate() * (position_b - position_a);
    const Eigen::Quaternion<T> difference = rotation.cast<T>().conjugate() * in_a;
    const T sign(difference.w() < T(0) ? -1 : 1);  // both signs are the same rotation
    Eigen::Matrix<T, 6, 1> error;
    error << p_in_a - position.cast<T>(), T(2) * sign * difference.vec();
    for (int row = 0; row < 6; row++) {
      residual[row] = whitening(row, 0) * error[0];
      for (int col = 1; col < 6; col++) residual[row] += whitening(row, col) * error[col];
    }
    return true;
  }
};

/** Least squares on the poses that constraints use. Of the maps that constraints connect with each
 * other, the first keeps its pose. */
class PoseProblem {
 public:
  /** \a squared_scale: squared error that halves the weight of a constraint (Cauchy's loss). */
  PoseProblem(const std::vector<PoseConstraint>& constraints, const Poses& pose,
              double squared_scale)
      : squared_scale_(squared_scale),
        parameters_(pose.size()),
        is_used_(pose.size()),
        first_of_(pose.size()),
        problem_(keepingManifold()) {
    auto* loss = new ceres::CauchyLoss(std::sqrt(squared_scale));  // owned by the problem
    for (size_t k = 0; k < pose.size(); k++)
      if (pose[k])
        parameters_[k] = {Eigen::Quaterniond(pose[k]->linear()).normalized(),
                          pose[k]->translation()};
    for (const PoseConstraint& c : constraints) {
      Parameters &a = parameters_[c.a], &b = parameters_[c.b];
      auto* cost = new ceres::AutoDiffCostFunction<Residual, 6, 4, 3, 4, 3>(new Residual{
          Eigen::Quaterniond(c.T_a_b.linear()).normalized(), c.T_a_b.translation(), c.whitening});
      problem_.AddResidualBlock(cost, loss, a.rotation.coeffs().data(), a.position.data(),
                                b.rotation.coeffs().data(), b.position.data());
      for (const size_t k : {c.a, c.b}) {
        if (is_used_[k]) continue;
        is_used_[k] = true;
        problem_.SetManifold(parameters_[k].rotation.coeffs().data(), &quaternions_);
      }
    }
    std::iota(first_of_.begin(), first_of_.end(), 0);
    for (const PoseConstraint& c : constraints) {
      const auto [first, other] = std::minmax({first_of_[c.a], first_of_[c.b]});
      std::replace(first_of_.begin(), first_of_.end(), other, first);
    }
    for (size_t k = 0; k < pose.size(); k++)
      if (is_used_[k] && !isFree(k))
        for (double* block : blocksOf(k)) problem_.SetParameterBlockConstant(block);
  }

  /** Writes the optimum, if it is usable. */
  void solve(Poses& pose) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    if (!summary.IsSolutionUsable()) return;
    for (size_t k = 0; k < pose.size(); k++)
      if (is_used_[k]) {
        pose[k]->linear() = parameters_[k].rotation.normalized().toRotationMatrix();
        pose[k]->translation() = parameters_[k].position;
      }
  }

  /** Returns the ratio of the disagreement of the constraints to the disagreement that their
   * covariances expect, at least 1. */
  double varianceFactor() {
    constexpr double kAgreeing = 6;  // degrees of freedom that are taken to agree
    ceres::Problem::EvaluateOptions options;
    options.apply_loss_function = false;
    std::vector<double> residuals;
    problem_.Evaluate(options, nullptr, &residuals, nullptr, nullptr);
    double weighted = 0;
    for (size_t i = 0; i < residuals.size(); i += 6) {
      const double squared = Eigen::Map<const Vector6d>(&residuals[i]).squaredNorm();
      weighted += squared / (1 + squared / squared_scale_);
    }
    double freedom = static_cast<double>(residuals.size());
    for (size_t k = 0; k < is_used_.size(); k++) freedom -= isFree(k) ? 6 : 0;
    return std::max(1.0, (weighted + kAgreeing) / (freedom + kAgreeing));
  }

  /** Returns the covariances of left perturbations of the poses; kUnknownVariance in all directions
   * if the constraints do not determine the poses. */
  std::vector<Matrix6d> covariances() {
    std::vector<Matrix6d> result(parameters_.size(), Matrix6d::Zero());
    ceres::Covariance::Options options;
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;  // one thread, the same bits
    options.num_threads = 1;
    ceres::Covariance covariance(options);
    std::vector<std::pair<const double*, const double*>> wanted;
    for (size_t k = 0; k < result.size(); k++) {
      if (!isFree(k)) continue;
      const auto [p, q] = blocksOf(k);
      wanted.insert(wanted.end(), {{p, p}, {p, q}, {q, q}});
    }
    const bool is_known = covariance.Compute(wanted, &problem_);
    for (size_t k = 0; k < result.size(); k++) {
      if (!isFree(k)) continue;
      result[k] = is_known ? covarianceOf(k, covariance) : kUnknownVariance * Matrix6d::Identity();
    }
    return result;
  }

 private:
  static ceres::Problem::Options keepingManifold() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  bool isFree(size_t k) const { return is_used_[k] && k != first_of_[k]; }

  /** Returns the position and the rotation of a map. */
  std::array<double*, 2> blocksOf(size_t k) {
    return {parameters_[k].position.data(), parameters_[k].rotation.coeffs().data()};
  }

  Matrix6d covarianceOf(size_t k, const ceres::Covariance& covariance) {
    const auto [p, q] = blocksOf(k);
    Eigen::Matrix<double, 6, 6, Eigen::RowMajor> of_parameters;
    covariance.GetCovarianceMatrixInTangentSpace({p, q}, of_parameters.data());
    // Ceres adds to the position, and rotates about the map's origin by twice the tangent.
    Matrix6d J = Matrix6d::Identity();
    J.topRightCorner<3, 3>() = 2 * skew(parameters_[k].position);
    J.bottomRightCorner<3, 3>() *= 2;
    const Matrix6d result = J * of_parameters * J.transpose();
    return 0.5 * (result + result.transpose());
  }

  double squared_scale_;
  std::vector<Parameters> parameters_;
  std::vector<bool> is_used_;
  std::vector<size_t> first_of_;  // the first map that constraints connect with a map
  ceres::EigenQuaternionManifold quaternions_;
  ceres::Problem problem_;
};

}  // namespace

PoseConstraint constraintOf(size_t a, size_t b, const Eigen::Isometry3d& T_a_b,
                            const Matrix6d& covariance) {
  Matrix6d J = Matrix6d::Zero();  // from a left perturbation to the error of PoseConstraint
  J.topLeftCorner<3, 3>().setIdentity();
  J.topRightCorner<3, 3>() = -skew(T_a_b.translation());
  J.bottomRightCorner<3, 3>() = T_a_b.linear().transpose();
  constexpr double kLeast = 1e-12;  // m^2 or rad^2; keeps a singular covariance invertible
  const Matrix6d of_error = J * covariance * J.transpose() + kLeast * Matrix6d::Identity();
  return {a, b, T_a_b, of_error.llt().matrixL().solve(Matrix6d::Identity())};
}

void optimizePoses(const std::vector<PoseConstraint>& constraints, Poses& pose) {
  if (constraints.empty()) return;
  PoseProblem(constraints, pose, kSquaredBound).solve(pose);
}

std::vector<Matrix6d> optimizeWithCovariance(const std::vector<PoseConstraint>& constraints,
                                             Poses& pose) {
  if (constraints.empty()) return std::vector<Matrix6d>(pose.size(), Matrix6d::Zero());
  PoseProblem problem(constraints, pose, kSquaredBound);
  problem.solve(pose);
  std::vector<Matrix6d> covariances = problem.covariances();
  const double factor = problem.varianceFactor();
  for (Matrix6d& covariance : covariances) covariance *= factor;
  return covariances;
}

}  // namespace mrpt::fusion
