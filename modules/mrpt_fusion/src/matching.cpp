// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/matching.h>

namespace mrpt::fusion {
namespace {

using OnIteration = std::function<void(const IterationRecord&)>;

/** What differs between the two levels: how to pair, with which weights, and what to minimise. */
struct LevelProblem {
  Level level;
  std::function<Pairs(const Eigen::Isometry3d&, const DescriptorWeights&)> associate;
  std::function<DescriptorWeights(double mse)> weights;
  std::function<NormalEquations(const Pairs&, const Eigen::Isometry3d&)> linearize;
};

/** The pairs at a pose. The weights need an MSE before there is one: that of the nearest neighbours
 * by distance alone. */
Pairs firstPairs(const LevelProblem& problem, const Eigen::Isometry3d& T) {
  const Pairs nearest = problem.associate(T, DescriptorWeights{});
  return problem.associate(T, problem.weights(meanSquaredError(nearest)));
}

/** Alternates association and optimisation until the pose stays. \return The last pairs. */
Pairs runLevel(const LevelProblem& problem, const LevelParams& level, const MatchParams& params,
               MatchResult& result, const OnIteration& on_iteration) {
  Pairs pairs = firstPairs(problem, result.T_a_b);
  for (unsigned i = 0; i < level.max_iterations; i++) {
    if (pairs.size() < MatchResult::kMinPairs) break;
    const double mse = meanSquaredError(pairs);
    const Eigen::Isometry3d T =
        optimizePose(result.T_a_b, SolverParams{}, [&](const Eigen::Isometry3d& candidate) {
          return problem.linearize(pairs, candidate);
        });
    const Eigen::Isometry3d step = T * result.T_a_b.inverse();
    // The step at the scene's own place: a rotation about a far origin is not a translation.
    const Eigen::Vector3d place = result.T_a_b.translation();
    const IterationRecord record{problem.level, pairs.size(), mse, (step * place - place).norm(),
                                 Eigen::AngleAxisd(step.linear()).angle()};
    result.T_a_b = T;
    result.iterations.push_back(record);
    if (on_iteration) on_iteration(record);
    pairs = problem.associate(T, problem.weights(mse));
    if (record.step_translation < params.min_step_translation &&
        record.step_rotation < params.min_step_rotation)
      break;
  }
  return pairs;
}

LevelProblem voxelLevel(const OccupiedVoxels& a, const OccupiedVoxels& b,
                        VoxelAssociation& association, double H_m, const MatchParams& params) {
  return {Level::Voxel,
          [&](const auto& T, const auto& w) {
            return association.associate(b, T, w, params.voxel_level.gate);
          },
          [&params, H_m](double mse) { return descriptorWeights(mse, H_m, 0, params.weights); },
          [&](const Pairs& pairs, const auto& T) { return linearizeVoxels(a, b, pairs, T); }};
}

}  // namespace

MapFeatures computeFeatures(const octomap::OcTree& map, const EdgeParams& params) {
  MapFeatures f;
  f.voxels = extractOccupiedVoxels(map);
  f.edges = extractEdges(f.voxels, params);
  return f;
}

MatchResult matchMaps(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                      const MatchParams& params, const OnIteration& on_iteration) {
  MatchResult result;
  result.T_a_b = T_a_b;
  if (a.voxels.size() == 0 || b.voxels.size() == 0) return result;
  const double H_m = occupancyUncertainty(a.voxels.probability, b.voxels.probability);

  if (a.edges.size() > 0 && b.edges.size() > 0) {
    const double lambda_tau = structuralUncertainty(a.edges, b.edges);
    EdgeAssociation association(a.edges);
    runLevel({Level::Edge,
              [&](const auto& T, const auto& w) {
                return association.associate(b.edges, T, w, params.edge_level.gate);
              },
              [&](double mse) { return descriptorWeights(mse, H_m, lambda_tau, params.weights); },
              [&](const Pairs& pairs, const auto& T) {
                return linearizeEdges(a.edges, b.edges, pairs, T, params.voxel_covariance);
              }},
             params.edge_level, params, result, on_iteration);
  }

  VoxelAssociation association(a.voxels);
  result.pairs = runLevel(voxelLevel(a.voxels, b.voxels, association, H_m, params),
                          params.voxel_level, params, result, on_iteration);
  if (result.hasPairs())
    result.covariance = poseCovariance(
        linearizeVoxels(a.voxels, b.voxels, result.pairs, result.T_a_b), result.pairs.size());
  return result;
}

Pairs pairVoxels(const OccupiedVoxels& a, const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                 const MatchParams& params) {
  if (a.size() == 0 || b.size() == 0) return {};
  VoxelAssociation association(a);
  const double H_m = occupancyUncertainty(a.probability, b.probability);
  return firstPairs(voxelLevel(a, b, association, H_m, params), T_a_b);
}

}  // namespace mrpt::fusion
