// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/matching.h>

#include <algorithm>
#include <limits>

namespace mrpt::fusion {
namespace {

/** What differs between the two levels: how to pair, with which weights, and what to minimise. */
struct LevelProblem {
  Level level;
  std::function<Pairs(const Eigen::Isometry3d&, const DescriptorWeights&, double gate)> associate;
  std::function<DescriptorWeights(double mse)> weights;
  std::function<NormalEquations(const Pairs&, const Eigen::Isometry3d&)> linearize;
};

/** The pairs at a pose. The weights need an MSE before there is one: that of the nearest neighbours
 * by distance alone. */
Pairs firstPairs(const LevelProblem& problem, const Eigen::Isometry3d& T, double gate) {
  const Pairs nearest = problem.associate(T, DescriptorWeights{}, gate);
  return problem.associate(T, problem.weights(meanSquaredError(nearest)), gate);
}

/** Alternates association and optimisation until the pose stays, from result.T_a_b on.
 * \return The last pairs. */
Pairs runLevel(const LevelProblem& problem, const LevelParams& level, double least_gate,
               const MatchParams& params, MatchResult& result, const OnIteration& on_iteration) {
  constexpr double kGateShrink = 0.8;
  const double final_gate = std::min(level.gate, std::max(level.final_gate, least_gate));
  double gate = level.gate;
  Pairs pairs = firstPairs(problem, result.T_a_b, gate);
  for (unsigned i = 0; i < level.max_iterations; i++) {
    if (pairs.size() < MatchResult::kMinPairs) break;
    const double mse = meanSquaredError(pairs);
    const Eigen::Isometry3d T = optimizePose(
        result.T_a_b, SolverParams{},
        [&](const Eigen::Isometry3d& candidate) { return problem.linearize(pairs, candidate); });
    const Eigen::Isometry3d step = T * result.T_a_b.inverse();
    // The step at the scene's own place: a rotation about a far origin is not a translation.
    const Eigen::Vector3d place = result.T_a_b.translation();
    const IterationRecord record{problem.level,
                                 pairs.size(),
                                 mse,
                                 (step * place - place).norm(),
                                 Eigen::AngleAxisd(step.linear()).angle(),
                                 T};
    result.T_a_b = T;
    result.iterations.push_back(record);
    if (on_iteration) on_iteration(record);
    const bool gate_is_final = gate <= final_gate;
    gate = std::max(final_gate, kGateShrink * gate);
    pairs = problem.associate(T, problem.weights(mse), gate);
    if (gate_is_final && record.step_translation < params.min_step_translation &&
        record.step_rotation < params.min_step_rotation)
      break;
  }
  return pairs;
}

/** The edge level, on result.T_a_b. */
void matchEdges(const MapFeatures& a, const MapFeatures& b, const MatchParams& params,
                MatchResult& result, const OnIteration& on_iteration) {
  if (a.edges.size() == 0 || b.edges.size() == 0) return;
  const double H_m = occupancyUncertainty(a.voxels.probability, b.voxels.probability);
  const double lambda_tau = structuralUncertainty(a.edges, b.edges);
  EdgeAssociation association(a.edges);
  runLevel({Level::Edge,
            [&](const auto& T, const auto& w, double gate) {
              return association.associate(b.edges, T, w, gate);
            },
            [&](double mse) { return descriptorWeights(mse, H_m, lambda_tau, params.weights); },
            [&](const Pairs& pairs, const auto& T) {
              return linearizeEdges(a.edges, b.edges, pairs, T, params.voxel_covariance);
            }},
           params.edge_level, 0, params, result, on_iteration);
}

/** How the voxel level pairs: all that judging a pose needs of it. */
LevelProblem voxelPairing(const OccupiedVoxels& a, const OccupiedVoxels& b,
                          VoxelAssociation& association, const MatchParams& params) {
  const double H_m = occupancyUncertainty(a.probability, b.probability);
  return {Level::Voxel,
          [&](const auto& T, const auto& w, double gate) {
            return association.associate(b, T, w, gate);
          },
          [&params, H_m](double mse) { return descriptorWeights(mse, H_m, 0, params.weights); },
          {}};
}

/** The least gate of voxel pairs, m. */
double twoVoxels(const MapFeatures& a, const MapFeatures& b) {
  return 2 * std::max(a.voxels.resolution, b.voxels.resolution);
}

LevelProblem voxelLevel(const MapFeatures& a, const MapFeatures& b, VoxelAssociation& association,
                        const MatchParams& params) {
  LevelProblem level = voxelPairing(a.voxels, b.voxels, association, params);
  level.linearize = [&](const Pairs& pairs, const auto& T) {
    return params.voxel_metric == VoxelMetric::Point
               ? linearizeVoxels(a.voxels, b.voxels, pairs, T)
               : linearizeSurfaces(a.voxels, a.surfaces, b.voxels, b.surfaces, pairs, T,
                                   params.flatness);
  };
  return level;
}

/** The voxel level from its gate \a first_gate on, on result.T_a_b; gives the result its covariance
 * and pairs. */
void matchVoxels(const MapFeatures& a, const MapFeatures& b, VoxelAssociation& association,
                 double first_gate, const MatchParams& params, MatchResult& result,
                 const OnIteration& on_iteration) {
  const LevelProblem level = voxelLevel(a, b, association, params);
  LevelParams from_gate = params.voxel_level;
  from_gate.gate = first_gate;
  const Pairs last = runLevel(level, from_gate, twoVoxels(a, b), params, result, on_iteration);
  if (last.size() >= MatchResult::kMinPairs)
    result.covariance = poseCovariance(level.linearize(last, result.T_a_b), last.size());
  result.pairs = firstPairs(level, result.T_a_b, params.voxel_level.gate);
}

bool isEmpty(const MapFeatures& a, const MapFeatures& b) {
  return a.voxels.size() == 0 || b.voxels.size() == 0;
}

}  // namespace

MapFeatures computeFeatures(const octomap::OcTree& map, const EdgeParams& params) {
  MapFeatures f;
  f.map = &map;
  f.voxels = extractOccupiedVoxels(map);
  f.surfaces = computeSurfaces(f.voxels, params);
  f.edges = extractEdges(f.voxels, f.surfaces.normal, params);
  return f;
}

MatchResult matchTwoLevel(const MapFeatures& a, const MapFeatures& b,
                          const Eigen::Isometry3d& T_a_b, const MatchParams& params,
                          const OnIteration& on_iteration) {
  MatchResult result;
  result.T_a_b = T_a_b;
  if (isEmpty(a, b)) return result;
  matchEdges(a, b, params, result, on_iteration);
  VoxelAssociation association(a.voxels);
  matchVoxels(a, b, association, params.voxel_level.gate, params, result, on_iteration);
  return result;
}

MapFeatures thinOut(const MapFeatures& features, double spacing) {
  const OccupiedVoxels& all = features.voxels;
  unsigned shift = 0;
  while (all.resolution * (1U << shift) < spacing * (1 - 1e-9) && shift < 15) shift++;
  const auto sameCube = [&](size_t i, size_t j) {
    for (unsigned axis = 0; axis < 3; axis++)
      if (all.key[i][axis] >> shift != all.key[j][axis] >> shift) return false;
    return true;
  };
  const auto isBetter = [&](size_t i, size_t j) {
    const bool flat_i = !features.surfaces.normal[i].isZero();
    const bool flat_j = !features.surfaces.normal[j].isZero();
    return flat_i != flat_j ? flat_i : all.probability[i] > all.probability[j];
  };

  MapFeatures few;
  few.map = features.map;
  few.edges = features.edges;
  few.voxels.resolution = all.resolution;
  for (size_t i = 0, next; i < all.size(); i = next) {
    size_t best = i;  // in the order of the octree's leaves a cube's voxels follow each other
    for (next = i + 1; next < all.size() && sameCube(i, next); next++)
      if (isBetter(next, best)) best = next;
    few.voxels.centre.push_back(all.centre[best]);
    few.voxels.probability.push_back(all.probability[best]);
    few.voxels.key.push_back(all.key[best]);
    few.surfaces.normal.push_back(features.surfaces.normal[best]);
    few.surfaces.point.push_back(features.surfaces.point[best]);
  }
  return few;
}

MatchResult matchMaps(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                      const MatchParams& params, const OnIteration& on_iteration) {
  if (isEmpty(a, b) || params.search.translation <= 0)
    return matchTwoLevel(a, b, T_a_b, params, on_iteration);

  MatchResult from_edges;
  from_edges.T_a_b = T_a_b;
  matchEdges(a, b, params, from_edges, on_iteration);
  const MapFeatures few_a = thinOut(a, params.search.cell), few_b = thinOut(b, params.search.cell);
  std::vector<Eigen::Isometry3d> starts = {from_edges.T_a_b};
  for (const Hypothesis& h : searchAround(*a.map, few_b.voxels, T_a_b, params.search))
    starts.push_back(h.T_a_b);

  VoxelAssociation association(a.voxels);
  const LevelProblem few_level = voxelLevel(a, few_b, association, params);
  MatchResult result;
  double best_agreement = -std::numeric_limits<double>::infinity();
  for (const Eigen::Isometry3d& start : starts) {
    MatchResult refined;
    refined.T_a_b = start;
    runLevel(few_level, params.voxel_level, twoVoxels(a, b), params, refined, {});
    const double reached = agreement(few_a, few_b, refined.T_a_b);
    if (reached <= best_agreement) continue;
    best_agreement = reached;
    result.T_a_b = refined.T_a_b;
  }
  result.iterations = from_edges.iterations;
  const double final_gate = std::max(params.voxel_level.final_gate, twoVoxels(a, b));
  matchVoxels(a, b, association, std::min(params.voxel_level.gate, final_gate), params, result,
              on_iteration);
  return result;
}

double agreement(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b) {
  const FreeSpaceCheck b_in_a = checkFreeSpace(*a.map, b.voxels, T_a_b);
  const FreeSpaceCheck a_in_b = checkFreeSpace(*b.map, a.voxels, T_a_b.inverse());
  return static_cast<double>(b_in_a.agreeing + a_in_b.agreeing) -
         kConflictWeight * static_cast<double>(b_in_a.conflicting + a_in_b.conflicting);
}

Pairs pairVoxels(const OccupiedVoxels& a, const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                 const MatchParams& params) {
  if (a.size() == 0 || b.size() == 0) return {};
  VoxelAssociation association(a);
  return firstPairs(voxelPairing(a, b, association, params), T_a_b, params.voxel_level.gate);
}

}  // namespace mrpt::fusion
