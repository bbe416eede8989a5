// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Measures the size of map B over the size of map A. */
#include "fusion_core/registration/size_ratio.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion_core/features/features.h"
#include "fusion_core/map/eigen_solvers.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_core/registration/residuals.h"
#include "fusion_core/registration/two_level.h"

namespace mrpt::fusion {
namespace {

constexpr size_t kSamplePairs = 1000;  // pairs in the first step
constexpr size_t kManyPairs = 4000;    // pairs in the steps of an enlarged map
constexpr int kMaxIterations = 30;
constexpr double kSettledStep = 0.3;   // growth of a converged iteration over its deviation
constexpr double kClearGrowth = 1e-2;  // growth that is measured by more than one step
constexpr double kMaxGrowth = 0.2;     // larger growth is no result of pairs of the same surfaces
constexpr double kLeastShare = 0.8;    // least number of final pairs over the first

using Vector7d = SimilarityEquations::Vector7d;
using Matrix7d = SimilarityEquations::Matrix7d;

/** A step of the similarity, and the standard deviation of its growth. */
struct Step {
  Vector7d xi = Vector7d::Zero();
  double deviation = std::numeric_limits<double>::infinity();
};

constexpr double kOppositeWalls = 2;  // walls with independent displacements that give a size

/** Solves the equations. The deviation is as that of poseCovariance(). \a common is the variance of
 * the distance that all pairs of a wall have in common, m^2: walls of coarse voxels are displaced
 * as a whole, and so seem nearer to each other or farther apart. */
Step solve(const SimilarityEquations& n, size_t pairs, double common) {
  // Rotation and growth are scaled to m.
  const double reach2 = n.H(6, 6) / n.H.topLeftCorner<3, 3>().trace();
  if (!(reach2 > 0)) return {};
  Vector7d unit = Vector7d::Ones();
  unit.tail<4>().setConstant(1 / std::sqrt(reach2));
  const SymmetricEigen<7> solution(unit.asDiagonal() * n.H * unit.asDiagonal());
  if (!(solution.eigenvalues[0] > kNoInformation * solution.eigenvalues[6])) return {};
  const Matrix7d V = unit.asDiagonal() * solution.eigenvectors;
  const Matrix7d inverse_H = V * solution.eigenvalues.cwiseInverse().asDiagonal() * V.transpose();
  const double freedom = std::max(1.0, 3 * static_cast<double>(pairs) - 7);
  const double residual_variance = std::max(n.error / freedom, 1e-12);
  const double correlated = (inverse_H * n.S).trace() / 7;
  const double shrinkage = 7 / (7 + static_cast<double>(n.patches));
  const double variance = (residual_variance + shrinkage * correlated) * inverse_H(6, 6) +
                          (1 - shrinkage) * (inverse_H * n.S * inverse_H)(6, 6) +
                          common / (kOppositeWalls * reach2);
  return {inverse_H * n.g, std::sqrt(variance)};
}

/** Map B, enlarged. */
SurfaceVoxels enlarged(const SurfaceVoxels& b, double factor) {
  SurfaceVoxels larger = b;
  for (auto* points : {&larger.voxels.centre, &larger.surfaces.point})
    for (Eigen::Vector3f& p : *points) p *= static_cast<float>(factor);
  return larger;
}

/** Applies a step about \a centre to the pose of B, and to the factor that enlarges B. */
void apply(const Vector7d& xi, const Eigen::Vector3d& centre, Eigen::Isometry3d& T,
           double& factor) {
  const double growth = std::exp(xi[6]);
  const Eigen::Vector3d w = xi.segment<3>(3);
  const double angle = w.norm();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  if (angle > 0) R = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  T.translation() = centre + growth * (R * (T.translation() - centre)) + xi.head<3>();
  T.linear() = R * T.linear();
  factor *= growth;
}

}  // namespace

SizeRatio sizeRatioAt(const SurfaceVoxels& a, const SurfaceVoxels& b, const Pairs& pairs,
                      const Eigen::Isometry3d& T_a_b, const VoxelAssociation& association,
                      double H_m, const RegistrationParams& params) {
  const auto some = [](const Pairs& all, size_t enough) {
    const size_t stride = strideFor(all.size(), enough);
    Pairs sample;
    for (size_t i = 0; i < all.size(); i += stride) sample.push_back(all[i]);
    return sample;
  };
  const double ra = a.voxels.resolution, rb = b.voxels.resolution;
  const double common = params.covariance.common_share * (ra * ra + rb * rb) / 12;
  const auto stepAt = [&](const SurfaceVoxels& of_b, const Pairs& of, Eigen::Isometry3d& T,
                          double& factor) {
    const SimilarityEquations n =
        linearizeSimilarity(a, of_b, of, T, params.flatness, params.covariance.patch_size);
    const Step step = solve(n, of.size(), common);
    apply(step.xi, n.centre, T, factor);
    return step;
  };
  if (pairs.size() < MatchResult::kMinPairs || params.voxel_metric == VoxelMetric::Point) return {};
  Eigen::Isometry3d T = T_a_b;
  double factor = 1;
  const Pairs sample = some(pairs, kSamplePairs);
  Step step = stepAt(b, sample, T, factor);
  // Before convergence the growth itself is part of the scatter: the deviation is too large.
  bool is_converged = std::abs(step.xi[6]) <= kClearGrowth;
  for (int i = 0; i < kMaxIterations && !is_converged; i++) {
    const SurfaceVoxels larger = enlarged(b, factor);
    VoxelLevel level(a, larger, H_m, association, params);
    const Pairs found = level.associate(T, level.weights(meanSquaredError(sample)),
                                        params.voxel_level.gate, nullptr);
    // At a wrong pose B shrinks or grows until its voxels are anywhere on A's.
    if (found.size() < kLeastShare * static_cast<double>(pairs.size())) return {};
    step = stepAt(larger, some(found, kManyPairs), T, factor);
    if (std::abs(std::log(factor)) > kMaxGrowth) return {};
    is_converged = std::abs(step.xi[6]) < kSettledStep * step.deviation;
  }
  if (!is_converged) return {};
  return {1 / factor, step.deviation / factor};
}

}  // namespace mrpt::fusion
