// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Runs the two levels of registration, and computes the final pairs. */
#include "fusion_core/registration/two_level.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>

#include "fusion_core/registration/observability.h"
#include "fusion_core/registration/pose_covariance.h"
#include "fusion_core/registration/residuals.h"
#include "fusion_core/registration/size_ratio.h"

namespace mrpt::fusion {
namespace {

/** The edge level, eq. (21). */
class EdgeLevel : public LevelProblem {
 public:
  EdgeLevel(const MapFeatures& a, const MapFeatures& b, const RegistrationParams& params)
      : a_(a.edges),
        b_(b.edges),
        params_(params),
        middle_(meanOf(b.edges.centre)),
        H_m_(occupancyUncertainty(a.voxels.probability, b.voxels.probability)),
        lambda_tau_(structuralUncertainty(a.edges, b.edges)),
        association_(a.edges) {}

  size_t size() const override { return b_.size(); }
  Pairs associate(const Eigen::Isometry3d& T_a_b, const DescriptorWeights& weights, double gate,
                  const Pairs* among) override {
    return association_.associate(b_, T_a_b, weights, gate, among);
  }
  DescriptorWeights weights(double mse) const override {
    return descriptorWeights(mse, H_m_, lambda_tau_, params_.weights);
  }
  Level level() const override { return Level::Edge; }
  Eigen::Vector3d middle() const override { return middle_; }
  NormalEquations linearize(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) const override {
    return linearizeEdges(a_, b_, pairs, T_a_b, params_.voxel_covariance);
  }
  double error(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) const override {
    return edgeError(a_, b_, pairs, T_a_b, params_.voxel_covariance);
  }

 private:
  const EdgeVoxels &a_, &b_;
  const RegistrationParams& params_;
  Eigen::Vector3d middle_;
  double H_m_, lambda_tau_;
  EdgeAssociation association_;
};

double largerVoxel(const MapVoxels& a, const MapVoxels& b) {
  return std::max(a.voxels.resolution, b.voxels.resolution);
}

}  // namespace

VoxelLevel::VoxelLevel(const SurfaceVoxels& a, const SurfaceVoxels& b, double H_m,
                       const VoxelAssociation& association, const RegistrationParams& params)
    : a_(a),
      b_(b),
      params_(params),
      middle_(meanOf(b.voxels.centre)),
      pairing_(b.voxels, H_m, association, params.weights) {}

NormalEquations VoxelLevel::linearize(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) const {
  return params_.voxel_metric == VoxelMetric::Point
             ? linearizeVoxels(a_.voxels, b_.voxels, pairs, T_a_b)
             : linearizeSurfaces(a_, b_, pairs, T_a_b, params_.flatness);
}

double VoxelLevel::error(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) const {
  return params_.voxel_metric == VoxelMetric::Point
             ? voxelError(a_.voxels, b_.voxels, pairs, T_a_b)
             : surfaceError(a_, b_, pairs, T_a_b, params_.flatness);
}

GradientScatter VoxelLevel::scatter(const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                                    const Eigen::Vector3d& centre) const {
  const double side = params_.covariance.patch_size;
  return params_.voxel_metric == VoxelMetric::Point
             ? scatterVoxels(a_.voxels, b_.voxels, pairs, T_a_b, centre, side)
             : scatterSurfaces(a_, b_, pairs, T_a_b, params_.flatness, centre, side);
}

Matrix6d VoxelLevel::commonCovariance(const Pairs& pairs, const Eigen::Vector3d& centre) const {
  // The quantisation error of both grids that remains if surface points replace the centres.
  const double ra = a_.voxels.resolution, rb = b_.voxels.resolution;
  const double share = params_.covariance.common_share;
  const double of_shift = share * (ra * ra + rb * rb) / 12;
  std::vector<Eigen::Vector3f> points;
  points.reserve(pairs.size());
  for (const Pair& p : pairs) points.push_back(b_.voxels.centre[p.b]);
  return fusion::commonCovariance(points, of_shift, share * of_shift, centre);
}

void matchEdges(const MapFeatures& a, const MapFeatures& b, const RegistrationParams& params,
                MatchResult& result, const OnIteration& on_iteration) {
  if (a.edges.size() == 0 || b.edges.size() == 0) return;
  EdgeLevel level(a, b, params);
  runLevel(level, params.edge_level, 0, params, result, on_iteration);
}

double leastVoxelGate(const MapFeatures& a, const MapFeatures& b,
                      const RegistrationParams& params) {
  return params.min_voxel_gate * largerVoxel(a, b);
}

VoxelAssociation associationOf(const MapFeatures& a, const MapFeatures& b,
                               const RegistrationParams& params) {
  VoxelAssociation association(a.matched.voxels);
  association.prepare(
      std::max(params.voxel_level.gate, params.covariance.held_gate * largerVoxel(a, b)));
  return association;
}

VoxelLevel voxelLevel(const MapFeatures& a, const MapFeatures& b,
                      const VoxelAssociation& association, const RegistrationParams& params) {
  const double H_m =
      occupancyUncertainty(a.matched.voxels.probability, b.matched.voxels.probability);
  return VoxelLevel(a.matched, b.matched, H_m, association, params);
}

Matrix6d covarianceOf(const MapFeatures& a, const MapFeatures& b, VoxelLevel& level,
                      const Eigen::Isometry3d& T_a_b, const RegistrationParams& params) {
  const Pairs pairs = firstPairs(level, T_a_b, leastVoxelGate(a, b, params), params.first_pairs);
  return pairs.size() >= MatchResult::kMinPairs
             ? covarianceAt(level, pairs, T_a_b, largerVoxel(a, b), params.covariance)
             : MatchResult().covariance;
}

void matchVoxels(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                 double first_gate, const RegistrationParams& params, size_t voxels,
                 MatchResult& result, const OnIteration& on_iteration) {
  VoxelLevel level = voxelLevel(a, b, association, params);
  LevelParams from_gate = params.voxel_level;
  from_gate.gate = first_gate;
  const Pairs last =
      runLevel(level, from_gate, leastVoxelGate(a, b, params), params, result, on_iteration);
  // Each of the two tasks has too little work for many threads.
  tbb::parallel_invoke(
      [&] {
        if (last.size() < MatchResult::kMinPairs) return;
        result.covariance =
            covarianceAt(level, last, result.T_a_b, largerVoxel(a, b), params.covariance);
        result.size_ratio =
            sizeRatioAt(a.matched, b.matched, last, result.T_a_b, association, level.H_m(), params);
      },
      [&] { result.pairs = pairVoxels(a, b, result.T_a_b, params, voxels); });
}

MatchResult matchTwoLevel(const MapFeatures& a, const MapFeatures& b,
                          const Eigen::Isometry3d& T_a_b, const RegistrationParams& params,
                          size_t voxels, const OnIteration& on_iteration) {
  MatchResult result;
  result.T_a_b = T_a_b;
  if (isEmpty(a, b)) return result;
  matchEdges(a, b, params, result, on_iteration);
  const VoxelAssociation association = associationOf(a, b, params);
  matchVoxels(a, b, association, params.voxel_level.gate, params, voxels, result, on_iteration);
  return result;
}

Pairs pairVoxels(const MapVoxels& a, const MapVoxels& b, const Eigen::Isometry3d& T_a_b,
                 const RegistrationParams& params, size_t voxels) {
  const size_t n = b.voxels.size();
  if (a.voxels.size() == 0 || n == 0) return {};
  VoxelAssociation association(a.voxels, a.occupied);
  association.prepare(params.voxel_level.gate);
  const double H_m = occupancyUncertainty(a.voxels.probability, b.voxels.probability);
  Pairs sample;
  const size_t stride = strideFor(n, voxels);
  for (size_t i = 0; i < n; i += stride) sample.push_back({0, static_cast<uint32_t>(i), 0});
  VoxelPairing pairing(b.voxels, H_m, association, params.weights);
  return firstPairs(pairing, T_a_b, params.voxel_level.gate, params.first_pairs, &sample);
}

}  // namespace mrpt::fusion
