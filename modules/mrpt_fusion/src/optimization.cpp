// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/optimization.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace mrpt::fusion {
namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/** Adds one pair: moving by xi takes e = m - q to e - J xi with J = [I, -[q]x] at q = T s. */
void addPair(const Eigen::Vector3d& e, const Eigen::Vector3d& q, const Eigen::Matrix3d& W,
             NormalEquations& n) {
  const Eigen::Matrix3d Q = skew(q);
  const Eigen::Matrix3d WQ = W * Q;
  const Eigen::Vector3d We = W * e;
  n.H.topLeftCorner<3, 3>() += W;
  n.H.topRightCorner<3, 3>() -= WQ;
  n.H.bottomRightCorner<3, 3>() += Q.transpose() * WQ;
  n.g.head<3>() += We;
  n.g.tail<3>() += Q * We;  // (-Q)' = Q
  n.error += e.dot(We);
}

/** Eq. (22)'s weight of a pair. */
double occupancyFactor(const OccupiedVoxels& model, const OccupiedVoxels& scene, const Pair& p) {
  return 1 / (1 / static_cast<double>(model.probability[p.model]) +
              1 / static_cast<double>(scene.probability[p.scene]));
}

void symmetrize(NormalEquations& n) {
  n.H.bottomLeftCorner<3, 3>() = n.H.topRightCorner<3, 3>().transpose();
}

}  // namespace

NormalEquations linearizeEdges(const EdgeVoxels& model, const EdgeVoxels& scene, const Pairs& pairs,
                               const Eigen::Isometry3d& T_a_b, VoxelCovariance kind) {
  const auto fused = [kind](const EdgeVoxels& edges, uint32_t i) {
    // Across a perfect line the neighbours do not spread, but each sits somewhere in its voxel.
    const double within_voxel = edges.resolution * edges.resolution / 12;
    return fuseCovariances(voxelVariance(edges.probability[i], edges.resolution, kind),
                           edges.covariance[i].matrix(within_voxel));
  };
  const Eigen::Matrix3d R = T_a_b.linear();
  NormalEquations n;
  for (const Pair& p : pairs) {
    const Eigen::Vector3d q = T_a_b * scene.centre[p.scene].cast<double>();
    const Eigen::Vector3d e = model.centre[p.model].cast<double>() - q;
    const Eigen::Matrix3d W =
        (fused(model, p.model) + R * fused(scene, p.scene) * R.transpose()).inverse();
    addPair(e, q, W, n);
  }
  symmetrize(n);
  return n;
}

NormalEquations linearizeSurfaces(const OccupiedVoxels& model,
                                  const std::vector<Eigen::Vector3f>& model_normal,
                                  const OccupiedVoxels& scene,
                                  const std::vector<Eigen::Vector3f>& scene_normal,
                                  const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                                  double flatness) {
  const Eigen::Matrix3d R = T_a_b.linear();
  NormalEquations n;
  for (const Pair& p : pairs) {
    const Eigen::Vector3d q = T_a_b * scene.centre[p.scene].cast<double>();
    const Eigen::Vector3d e = model.centre[p.model].cast<double>() - q;
    const Eigen::Vector3d n_m = model_normal[p.model].cast<double>();
    const Eigen::Vector3d n_s = R * scene_normal[p.scene].cast<double>();
    const Eigen::Matrix3d C = 2 * Eigen::Matrix3d::Identity() -
                              (1 - flatness) * (n_m * n_m.transpose() + n_s * n_s.transpose());
    addPair(e, q, occupancyFactor(model, scene, p) * C.inverse(), n);
  }
  symmetrize(n);
  return n;
}

NormalEquations linearizeVoxels(const OccupiedVoxels& model, const OccupiedVoxels& scene,
                                const Pairs& pairs, const Eigen::Isometry3d& T_a_b) {
  NormalEquations n;
  for (const Pair& p : pairs) {
    const Eigen::Vector3d q = T_a_b * scene.centre[p.scene].cast<double>();
    const Eigen::Vector3d e = model.centre[p.model].cast<double>() - q;
    addPair(e, q, occupancyFactor(model, scene, p) * Eigen::Matrix3d::Identity(), n);
  }
  symmetrize(n);
  return n;
}

Eigen::Isometry3d expSE3(const Vector6d& xi) {
  const Eigen::Vector3d w = xi.tail<3>();
  const double angle = w.norm();
  const Eigen::Matrix3d W = skew(w);
  double a = 0.5, b = 1.0 / 6;  // (1 - cos)/angle^2 and (angle - sin)/angle^3
  if (angle > 1e-4) {
    a = (1 - std::cos(angle)) / (angle * angle);
    b = (angle - std::sin(angle)) / (angle * angle * angle);
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (angle > 0) T.linear() = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  T.translation() = (Eigen::Matrix3d::Identity() + a * W + b * W * W) * xi.head<3>();
  return T;
}

namespace {
/** H^-1 by its eigenvectors, where eigenvalues too small to be information act as infinite or as
 * \a unknown (the inverse's value there). */
Matrix6d inverseOf(const Matrix6d& H, double unknown) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(H);
  const double least = 1e-10 * std::max(solver.eigenvalues().maxCoeff(), 1e-300);
  Vector6d inverse;
  for (int i = 0; i < 6; i++) {
    const double value = solver.eigenvalues()[i];
    inverse[i] = value > least ? 1 / value : unknown;
  }
  return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}
}  // namespace

Vector6d solveDamped(const NormalEquations& equations, double lambda) {
  Matrix6d H = equations.H;
  H.diagonal() *= 1 + lambda;
  return inverseOf(H, 0) * equations.g;
}

Matrix6d poseCovariance(const NormalEquations& at_optimum, size_t pairs, double unknown_variance) {
  const double freedom = std::max(1.0, 3 * static_cast<double>(pairs) - 6);
  const double residual_variance = std::max(at_optimum.error / freedom, 1e-12);
  return residual_variance * inverseOf(at_optimum.H, unknown_variance / residual_variance);
}

}  // namespace mrpt::fusion
