// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/pair/matching.h"

#include <mrpt/fusion/evaluation.h>
#include <tbb/parallel_invoke.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "fusion_base/parallel.h"

namespace mrpt::fusion {
namespace {

constexpr double kHeldGate = 3;  // voxels, see LevelProblem::heldHessian()

/** What differs between the two levels: how to pair, with which weights, and what to minimise. */
struct LevelProblem {
  Level level;
  size_t scene_size;
  Eigen::Vector3d middle;  ///< of the scene, m, its frame
  /** Of all scene voxels, or of those among some pairs. */
  std::function<Pairs(const Eigen::Isometry3d&, const DescriptorWeights&, double gate,
                      const Pairs*)>
      associate;
  std::function<DescriptorWeights(double mse)> weights;
  std::function<NormalEquations(const Pairs&, const Eigen::Isometry3d&)> linearize;
  std::function<double(const Pairs&, const Eigen::Isometry3d&)> error;
  /** At a pose, about a centre. */
  std::function<GradientScatter(const Pairs&, const Eigen::Isometry3d&, const Eigen::Vector3d&)>
      scatter;
  double common_variance = 0;  ///< of a shift that all pairs have in common, m^2

  /** \param[in] step See heldHessian(), m. */
  Matrix6d covarianceAt(const Pairs& pairs, const Eigen::Isometry3d& T, double step) const {
    NormalEquations equations = linearize(pairs, T);
    const GradientScatter gradients = scatter(pairs, T, equations.centre);
    equations.H = heldHessian(equations, pairs, T, step);
    Matrix6d covariance = poseCovariance(equations, pairs.size(), gradients);
    // Floors and walls along a grid all lie by the same part of a voxel off their voxels' middles.
    covariance.topLeftCorner<3, 3>() += common_variance * Eigen::Matrix3d::Identity();
    return covariance;
  }

  /** The Hessian is that of given pairs; but a wall that slides along itself pairs with the next
   * piece of itself. So each of its eigenvectors counts only as far as the pull back to the pose
   * grows when the scene is moved along it, by a \a step (m) to either side, and paired anew. */
  Matrix6d heldHessian(const NormalEquations& equations, const Pairs& pairs,
                       const Eigen::Isometry3d& T, double step) const {
    constexpr size_t kEnough = 600;
    constexpr double kNotHeld = 0.1;  // 0.6 and more where anything holds, 0.0x along a corridor
    const size_t stride = strideFor(pairs.size(), kEnough);
    Pairs some;
    for (size_t i = 0; i < pairs.size(); i += stride) some.push_back(pairs[i]);
    const NormalEquations at_rest = linearize(some, T);
    const DescriptorWeights w = weights(meanSquaredError(some));
    const auto pullAt = [&](const Vector6d& xi) {
      const Eigen::Isometry3d moved = perturb(T, xi, at_rest.centre);
      return linearize(associate(moved, w, kHeldGate * step, &some), moved).about(at_rest.centre).g;
    };

    // Rotations in metres, at the pairs' distance from their centre.
    const double reach2 =
        equations.H.bottomRightCorner<3, 3>().trace() / equations.H.topLeftCorner<3, 3>().trace();
    if (!(reach2 > 0)) return equations.H;
    Vector6d scale = Vector6d::Ones();
    scale.tail<3>() /= std::sqrt(reach2);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(scale.asDiagonal() * equations.H *
                                                        scale.asDiagonal());
    Vector6d held = eigen.eigenvalues();
    for (int i = 0; i < 6; i++) {
      const Vector6d xi = step * scale.cwiseProduct(eigen.eigenvectors().col(i));
      const double expected = 2 * xi.dot(at_rest.H * xi);
      const double found = expected > 0 ? xi.dot(pullAt(-xi) - pullAt(xi)) / expected : 0;
      held[i] *= found < kNotHeld ? 0 : std::min(found, 1.0);
    }
    const Matrix6d V = scale.cwiseInverse().asDiagonal() * eigen.eigenvectors();
    return V * held.asDiagonal() * V.transpose();
  }
};

/** The pairs at a pose, of all scene voxels or of those \a among some. The weights need an MSE
 * before there is one: that of the nearest neighbours by distance alone, of so many voxels as tell
 * it. */
Pairs firstPairs(const LevelProblem& problem, const Eigen::Isometry3d& T, double gate,
                 const Pairs* among = nullptr) {
  constexpr size_t kEnough = 4000;
  const size_t all = among ? among->size() : problem.scene_size;
  const size_t stride = strideFor(all, kEnough);
  Pairs some;
  for (size_t i = 0; i < all; i += stride)
    some.push_back({0, among ? (*among)[i].scene : static_cast<uint32_t>(i), 0});
  const Pairs nearest = problem.associate(T, DescriptorWeights{}, gate, &some);
  return problem.associate(T, problem.weights(meanSquaredError(nearest)), gate, among);
}

/** Alternates association and optimisation until the pose stays, from result.T_a_b on.
 * \return The last pairs. */
Pairs runLevel(const LevelProblem& problem, const LevelParams& level, double least_gate,
               const MatchParams& params, MatchResult& result, const OnIteration& on_iteration) {
  constexpr double kGateShrink = 0.8;
  constexpr double kSettled = 0.05;  // of the gate: a longer step still needs the far pairs
  const double final_gate = std::min(level.gate, std::max(level.final_gate, least_gate));
  double gate = level.gate;
  Pairs pairs = firstPairs(problem, result.T_a_b, gate);
  for (unsigned i = 0; i < level.max_iterations; i++) {
    if (pairs.size() < MatchResult::kMinPairs) break;
    const double mse = meanSquaredError(pairs);
    const Eigen::Isometry3d T = optimizePose(
        result.T_a_b, params.solver,
        [&](const Eigen::Isometry3d& at) { return problem.linearize(pairs, at); },
        [&](const Eigen::Isometry3d& at) { return problem.error(pairs, at); });
    const Eigen::Isometry3d step = T * result.T_a_b.inverse();
    // The step of the scene itself: a rotation about a far origin is not a translation.
    const Eigen::Vector3d place = result.T_a_b * problem.middle;
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
    if (record.step_translation < kSettled * gate) gate = std::max(final_gate, kGateShrink * gate);
    pairs = problem.associate(T, problem.weights(mse), gate, nullptr);
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
  LevelProblem problem;
  problem.level = Level::Edge;
  problem.scene_size = b.edges.size();
  problem.middle = meanOf(b.edges.centre);
  problem.associate = [&](const auto& T, const auto& w, double gate, const Pairs* among) {
    return association.associate(b.edges, T, w, gate, among);
  };
  problem.weights = [&](double mse) {
    return descriptorWeights(mse, H_m, lambda_tau, params.weights);
  };
  problem.linearize = [&](const Pairs& pairs, const auto& T) {
    return linearizeEdges(a.edges, b.edges, pairs, T, params.voxel_covariance);
  };
  problem.error = [&](const Pairs& pairs, const auto& T) {
    return edgeError(a.edges, b.edges, pairs, T, params.voxel_covariance);
  };
  runLevel(problem, params.edge_level, 0, params, result, on_iteration);
}

/** How the voxel level pairs: all that judging a pose needs of it. \param[in] H_m See
 * occupancyUncertainty(). \param[in] association Prepared for the gates to come. */
LevelProblem voxelPairing(const OccupiedVoxels& b, double H_m, const VoxelAssociation& association,
                          const MatchParams& params) {
  LevelProblem problem;
  problem.level = Level::Voxel;
  problem.scene_size = b.size();
  problem.middle = meanOf(b.centre);
  problem.associate = [&, last = VoxelAssociation::Partners()](
                          const auto& T, const auto& w, double gate, const Pairs* among) mutable {
    return association.associate(b, T, w, gate, among, &last);
  };
  problem.weights = [&params, H_m](double mse) {
    return descriptorWeights(mse, H_m, 0, params.weights);
  };
  return problem;
}

LevelProblem voxelLevel(const SurfaceVoxels& a, const SurfaceVoxels& b, double H_m,
                        const VoxelAssociation& association, const MatchParams& params) {
  LevelProblem level = voxelPairing(b.voxels, H_m, association, params);
  level.linearize = [&](const Pairs& pairs, const auto& T) {
    return params.voxel_metric == VoxelMetric::Point
               ? linearizeVoxels(a.voxels, b.voxels, pairs, T)
               : linearizeSurfaces(a.voxels, a.surfaces, b.voxels, b.surfaces, pairs, T,
                                   params.flatness);
  };
  level.error = [&](const Pairs& pairs, const auto& T) {
    return params.voxel_metric == VoxelMetric::Point
               ? voxelError(a.voxels, b.voxels, pairs, T)
               : surfaceError(a.voxels, a.surfaces, b.voxels, b.surfaces, pairs, T,
                              params.flatness);
  };
  // What is left of both grids' quantisation with surfaces' points in place of the voxels' middles.
  constexpr double kLeft = 1.0 / 3;
  const double ra = a.voxels.resolution, rb = b.voxels.resolution;
  level.common_variance = kLeft * (ra * ra + rb * rb) / 12;
  level.scatter = [&](const Pairs& pairs, const auto& T, const auto& centre) {
    constexpr double kPatch = 6;  // m
    return params.voxel_metric == VoxelMetric::Point
               ? scatterVoxels(a.voxels, b.voxels, pairs, T, centre, kPatch)
               : scatterSurfaces(a.voxels, a.surfaces, b.voxels, b.surfaces, pairs, T,
                                 params.flatness, centre, kPatch);
  };
  return level;
}

double largerVoxel(const MapFeatures& a, const MapFeatures& b) {
  return std::max(a.voxels.resolution, b.voxels.resolution);
}
/** The least gate of voxel pairs, m. */
double twoVoxels(const MapFeatures& a, const MapFeatures& b) { return 2 * largerVoxel(a, b); }

/** Of a's matched voxels, ready for all gates of the voxel level and of its covariance: threads may
 * share it. */
VoxelAssociation associationOf(const MapFeatures& a, const MapFeatures& b,
                               const MatchParams& params) {
  VoxelAssociation association(a.matched.voxels);
  association.prepare(std::max(params.voxel_level.gate, kHeldGate * largerVoxel(a, b)));
  return association;
}

/** With all of the maps' matched voxels. */
LevelProblem voxelLevel(const MapFeatures& a, const MapFeatures& b,
                        const VoxelAssociation& association, const MatchParams& params) {
  const double H_m =
      occupancyUncertainty(a.matched.voxels.probability, b.matched.voxels.probability);
  return voxelLevel(a.matched, b.matched, H_m, association, params);
}

/** The covariance of a pose by a level's pairs there. */
Matrix6d covarianceOf(const MapFeatures& a, const MapFeatures& b, const LevelProblem& level,
                      const Eigen::Isometry3d& T) {
  const Pairs pairs = firstPairs(level, T, twoVoxels(a, b));
  return pairs.size() >= MatchResult::kMinPairs ? level.covarianceAt(pairs, T, largerVoxel(a, b))
                                                : MatchResult().covariance;
}

/** The voxel level from its gate \a first_gate on, on result.T_a_b; gives the result its covariance
 * and pairs. */
void matchVoxels(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                 double first_gate, const MatchParams& params, MatchResult& result,
                 const OnIteration& on_iteration) {
  const LevelProblem level = voxelLevel(a, b, association, params);
  LevelParams from_gate = params.voxel_level;
  from_gate.gate = first_gate;
  const Pairs last = runLevel(level, from_gate, twoVoxels(a, b), params, result, on_iteration);
  // Neither alone keeps many threads busy.
  tbb::parallel_invoke(
      [&] {
        if (last.size() >= MatchResult::kMinPairs)
          result.covariance = level.covarianceAt(last, result.T_a_b, largerVoxel(a, b));
      },
      [&] { result.pairs = pairVoxels(a, b, result.T_a_b, params); });
}

OccupiedVoxels select(const OccupiedVoxels& voxels, const std::vector<uint32_t>& indices) {
  OccupiedVoxels some;
  some.resolution = voxels.resolution;
  some.centre.reserve(indices.size());
  some.probability.reserve(indices.size());
  some.key.reserve(indices.size());
  for (const uint32_t i : indices) {
    some.centre.push_back(voxels.centre[i]);
    some.probability.push_back(voxels.probability[i]);
    some.key.push_back(voxels.key[i]);
  }
  return some;
}

Surfaces select(const Surfaces& surfaces, const std::vector<uint32_t>& indices) {
  Surfaces some;
  for (const uint32_t i : indices) {
    some.normal.push_back(surfaces.normal[i]);
    some.point.push_back(surfaces.point[i]);
    some.variation.push_back(surfaces.variation[i]);
    some.weight.push_back(surfaces.weight[i]);
  }
  return some;
}

bool isEmpty(const MapFeatures& a, const MapFeatures& b) {
  return a.voxels.size() == 0 || b.voxels.size() == 0;
}

}  // namespace

MapFeatures computeFeatures(const octomap::OcTree& map, const MatchParams& params) {
  MapFeatures f{MapVoxels(map), {}, {}};
  const auto kept = thinOut(f.voxels, params.voxel_spacing);
  f.matched.voxels = select(f.voxels, kept.index);
  f.matched.surfaces = computeSurfaces(f.matched.voxels, f.occupied, params.edges);
  f.matched.surfaces.weight = kept.weight;
  f.edges = extractEdges(f.voxels, f.occupied, f.matched, edgeCandidates(f.matched, params),
                         params.edges);
  return f;
}

MapFeatures featuresOfEdges(const octomap::OcTree& map, const octomap::OcTree& edge_tree,
                            const EdgeVoxels& edges) {
  MapFeatures f{MapVoxels(map), {extractOccupiedVoxels(edge_tree), {}}, edges};
  const size_t n = f.matched.voxels.size();
  f.matched.surfaces.normal.assign(n, Eigen::Vector3f::Zero());
  f.matched.surfaces.point = f.matched.voxels.centre;
  f.matched.surfaces.variation.assign(n, 0);
  f.matched.surfaces.weight.assign(n, 1);
  return f;
}

std::vector<uint32_t> edgeCandidates(const SurfaceVoxels& matched, const MatchParams& params) {
  const std::vector<float>& variation = matched.surfaces.variation;
  return thinOut(matched.voxels, params.edge_spacing,
                 [&](uint32_t i, uint32_t j) { return variation[i] > variation[j]; })
      .index;
}

std::pair<MapFeatures, MapFeatures> computeFeatures(const octomap::OcTree& map_a,
                                                    const octomap::OcTree& map_b,
                                                    const MatchParams& params) {
  std::pair<MapFeatures, MapFeatures> features;
  tbb::parallel_invoke([&] { features.first = computeFeatures(map_a, params); },
                       [&] { features.second = computeFeatures(map_b, params); });
  return features;
}

MatchResult matchTwoLevel(const MapFeatures& a, const MapFeatures& b,
                          const Eigen::Isometry3d& T_a_b, const MatchParams& params,
                          const OnIteration& on_iteration) {
  MatchResult result;
  result.T_a_b = T_a_b;
  if (isEmpty(a, b)) return result;
  matchEdges(a, b, params, result, on_iteration);
  const VoxelAssociation association = associationOf(a, b, params);
  matchVoxels(a, b, association, params.voxel_level.gate, params, result, on_iteration);
  return result;
}

Thinned thinOut(const OccupiedVoxels& voxels, double spacing) {
  return thinOut(voxels, spacing, [&](uint32_t i, uint32_t j) {
    return voxels.probability[i] > voxels.probability[j];
  });
}

namespace {

/** Few voxels, spread evenly, to compare poses with; those that have a normal first. */
SurfaceVoxels fewOf(const SurfaceVoxels& all, double spacing, size_t enough) {
  const OccupiedVoxels& voxels = all.voxels;
  const Surfaces& surfaces = all.surfaces;
  const auto kept = thinOut(voxels, spacing, [&](uint32_t i, uint32_t j) {
    const bool flat_i = !surfaces.normal[i].isZero(), flat_j = !surfaces.normal[j].isZero();
    return flat_i != flat_j ? flat_i : voxels.probability[i] > voxels.probability[j];
  });
  std::vector<uint32_t> few;
  const size_t stride = strideFor(kept.index.size(), enough);
  for (size_t k = 0; k < kept.index.size(); k += stride) few.push_back(kept.index[k]);
  return {select(voxels, few), select(surfaces, few)};
}

/** How far apart two poses are, 1 where the paper's failure begins. \param[in] middle Of map B. */
double distanceBetween(const Eigen::Isometry3d& T, const Eigen::Isometry3d& U,
                       const Eigen::Vector3d& middle) {
  constexpr double kFar = 0.6, kTurned = 6 * M_PI / 180;
  const Eigen::Isometry3d between = T.inverse() * U;
  return std::max((between * middle - middle).norm() / kFar,
                  Eigen::AngleAxisd(between.linear()).angle() / kTurned);
}
bool isSamePlace(const Eigen::Isometry3d& T, const Eigen::Isometry3d& U,
                 const Eigen::Vector3d& middle) {
  return distanceBetween(T, U, middle) <= 1;
}

bool agreesBetter(const RankedPose& g, const RankedPose& h) { return g.agreement > h.agreement; }

/** Best first; of those that came to the same place the best. \param[in] middle Of map B. */
std::vector<RankedPose> distinct(std::vector<RankedPose> all, const Eigen::Vector3d& middle) {
  std::stable_sort(all.begin(), all.end(), agreesBetter);
  std::vector<RankedPose> best;
  for (const RankedPose& h : all) {
    const bool is_new = std::none_of(best.begin(), best.end(), [&](const RankedPose& g) {
      return isSamePlace(g.T_a_b, h.T_a_b, middle);
    });
    if (is_new) best.push_back(h);
  }
  return best;
}

/** Compares poses by some voxels of each map: refines them on these, and asks how well the maps
 * agree there. */
class PoseComparison {
 public:
  /** \param[in] voxels So many of each map. \param[in] few_b B's, see sceneVoxels().
   * \param[in] association Of a's matched voxels. */
  PoseComparison(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                 const MatchParams& params, size_t voxels, SurfaceVoxels few_b)
      : a_(a),
        b_(b),
        association_(association),
        params_(roughly(params)),
        few_b_(std::move(few_b)) {
    tbb::parallel_invoke(
        [&] { of_a_ = obstaclesOf(a, fewOf(a.matched, params.search.cell, voxels)); },
        [&] {
          of_b_ = obstaclesOf(b, few_b_);
          H_m_ = occupancyUncertainty(a.matched.voxels.probability, few_b_.voxels.probability);
        });
  }
  PoseComparison(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                 const MatchParams& params, size_t voxels)
      : PoseComparison(a, b, association, params, voxels, sceneVoxels(b, params, voxels)) {}

  static SurfaceVoxels sceneVoxels(const MapFeatures& b, const MatchParams& params, size_t voxels) {
    return fewOf(b.matched, params.search.cell, voxels);
  }

  /** What the starts come to, best first; of those that come to the same place the best. */
  std::vector<RankedPose> ranked(const std::vector<Eigen::Isometry3d>& starts) const {
    std::vector<RankedPose> reached(starts.size());
    forEachIndex(starts.size(), 1, [&](size_t i) { reached[i] = refined(starts[i]); });
    return distinct(std::move(reached), meanOf(few_b_.voxels.centre));
  }

  /** As MatchResult::covariance, by these voxels. */
  Matrix6d covarianceAt(const Eigen::Isometry3d& T) const {
    return covarianceOf(a_, b_, level(), T);
  }

  /** How well the maps agree there, see agreement(). */
  double agreementAt(const Eigen::Isometry3d& T) const {
    return agreement(a_, of_a_, b_, of_b_, T);
  }

  /** Poses are compared before they are known better than this. */
  static MatchParams roughly(MatchParams params) {
    constexpr unsigned kEnough = 15;
    params.voxel_level.max_iterations = std::min(params.voxel_level.max_iterations, kEnough);
    params.min_step_translation = std::max(params.min_step_translation, 0.01);
    params.min_step_rotation = std::max(params.min_step_rotation, 0.002);
    params.solver.max_steps = 1;
    return params;
  }

 private:
  /** Its own for each thread. */
  LevelProblem level() const { return voxelLevel(a_.matched, few_b_, H_m_, association_, params_); }

  RankedPose refined(const Eigen::Isometry3d& start) const {
    MatchResult result;
    result.T_a_b = start;
    runLevel(level(), params_.voxel_level, twoVoxels(a_, b_), params_, result, {});
    return {result.T_a_b, agreementAt(result.T_a_b), result.covariance};
  }

  const MapFeatures &a_, &b_;
  const VoxelAssociation& association_;
  const MatchParams params_;
  SurfaceVoxels few_b_;
  double H_m_ = 0;
  Obstacles of_a_, of_b_;
};

}  // namespace

namespace {

constexpr double kLeastOfRivals = 0.05;   // of the best's agreement
constexpr size_t kVoxelsOfRivals = 5000;  // poses that rival differ by more than chance on these

/** Compares the poses that rival with the best once more, by more voxels. */
void compareRivals(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                   const MatchParams& params, std::vector<RankedPose>& hypotheses) {
  constexpr size_t kMost = 4;
  std::vector<Eigen::Isometry3d> poses;
  for (const RankedPose& h : hypotheses)
    if (poses.size() < kMost && h.agreement > kLeastOfRivals * hypotheses.front().agreement)
      poses.push_back(h.T_a_b);
  if (poses.size() < 2) return;
  auto compared = PoseComparison(a, b, association, params, kVoxelsOfRivals).ranked(poses);
  // The others stay as far behind as they were.
  const double scale = compared.front().agreement / hypotheses.front().agreement;
  for (size_t i = poses.size(); i < hypotheses.size(); i++) {
    hypotheses[i].agreement *= scale;
    compared.push_back(hypotheses[i]);
  }
  hypotheses = distinct(std::move(compared), meanOf(b.matched.voxels.centre));
}

/** All voxels may take the best pose elsewhere than the few did by which it was compared. Then what
 * they came to is compared with the others: it is the first, whatever they are worth. */
void compareWhatWasReached(const MapFeatures& a, const MapFeatures& b,
                           const VoxelAssociation& association, const MatchParams& params,
                           MatchResult& result) {
  constexpr double kNear = 1.0 / 3;  // of the paper's failure: 0.2 m, 2 degrees
  const Eigen::Vector3d middle = meanOf(b.matched.voxels.centre);
  if (distanceBetween(result.hypotheses.front().T_a_b, result.T_a_b, middle) <= kNear) return;
  std::vector<RankedPose> compared{{result.T_a_b, 0, result.covariance}};
  for (const RankedPose& h : result.hypotheses)
    if (!isSamePlace(h.T_a_b, result.T_a_b, middle)) compared.push_back(h);
  const PoseComparison comparison(a, b, association, params, kVoxelsOfRivals);
  forEachIndex(compared.size(), 1, [&](size_t i) {
    compared[i].agreement = comparison.agreementAt(compared[i].T_a_b);
  });
  std::stable_sort(compared.begin() + 1, compared.end(), agreesBetter);
  result.hypotheses = std::move(compared);
}

}  // namespace

MatchResult matchMaps(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                      const MatchParams& params, const OnIteration& on_iteration) {
  if (isEmpty(a, b) || params.search.translation <= 0)
    return matchTwoLevel(a, b, T_a_b, params, on_iteration);

  // All starts by few voxels first, if there are many: those are a quarter of the work.
  constexpr size_t kFew = 250, kMany = 1000, kMostByMany = 24;
  MatchResult result;
  result.T_a_b = T_a_b;
  std::vector<Eigen::Isometry3d> starts;
  std::optional<VoxelAssociation> of_voxels;
  std::optional<PoseComparison> comparison;
  std::vector<Hypothesis> found;
  const SurfaceVoxels scene = PoseComparison::sceneVoxels(b, params, kMany);
  tbb::parallel_invoke(
      [&] {
        if (params.search.isEverywhere()) return;
        matchEdges(a, b, PoseComparison::roughly(params), result, on_iteration);
        starts.push_back(result.T_a_b);
      },
      [&] {
        of_voxels.emplace(associationOf(a, b, params));
        comparison.emplace(a, b, *of_voxels, params, kMany, scene);
      },
      [&] {
        const bool turns =
            params.search.isEverywhere() && params.search.rotations == SearchRotations::All;
        found = turns ? searchAllRotations(a, a.matched.surfaces, scene, params.search)
                      : searchAround(a, a.matched.surfaces, scene, T_a_b, params.search);
      });
  const VoxelAssociation& association = *of_voxels;
  const PoseComparison& by_many = *comparison;
  for (const Hypothesis& h : found) starts.push_back(h.T_a_b);
  if (starts.empty()) starts.push_back(T_a_b);
  if (starts.size() > kMostByMany) {
    const auto best = PoseComparison(a, b, association, params, kFew).ranked(starts);
    starts.clear();
    for (size_t i = 0; i < std::min(best.size(), kMostByMany); i++) starts.push_back(best[i].T_a_b);
  }
  result.hypotheses = by_many.ranked(starts);
  compareRivals(a, b, association, params, result.hypotheses);
  result.T_a_b = result.hypotheses.front().T_a_b;
  const double final_gate = std::max(params.voxel_level.final_gate, twoVoxels(a, b));
  // What is asked of the hypotheses does not keep many threads busy either.
  tbb::parallel_invoke(
      [&] {
        forEachIndex(result.hypotheses.size(), 1, [&](size_t i) {
          RankedPose& h = result.hypotheses[i];
          if (h.agreement > kLeastOfRivals * result.hypotheses.front().agreement)
            h.covariance = by_many.covarianceAt(h.T_a_b);
        });
      },
      [&] {
        matchVoxels(a, b, association, std::min(params.voxel_level.gate, final_gate), params,
                    result, on_iteration);
      });
  compareWhatWasReached(a, b, association, params, result);
  return result;
}

namespace {

/** Where the maps agree so much better than at the match that this is less than \a as_good of it:
 * the best pose of all, as the second of result.hypotheses. */
bool findBetterElsewhere(const MapFeatures& a, const MapFeatures& b, double as_good,
                         const MatchParams& params, MatchResult& result) {
  MatchParams unbounded = params;
  unbounded.search = everywhere(params.search);
  const MatchResult elsewhere = matchMaps(a, b, result.T_a_b, unbounded);
  const VoxelAssociation association = associationOf(a, b, params);
  const auto ranked = PoseComparison(a, b, association, params, kVoxelsOfRivals)
                          .ranked({result.T_a_b, elsewhere.T_a_b});
  if (ranked.size() < 2 || ranked[1].agreement > as_good * ranked[0].agreement ||
      isSamePlace(ranked[0].T_a_b, result.T_a_b, meanOf(b.matched.voxels.centre)))
    return false;
  if (result.hypotheses.empty())
    result.hypotheses.push_back({result.T_a_b, ranked[1].agreement, result.covariance});
  RankedPose better = ranked[0];
  better.agreement *= result.hypotheses.front().agreement / ranked[1].agreement;
  result.hypotheses.insert(result.hypotheses.begin() + 1, better);
  return true;
}

}  // namespace

Evaluation judgeMatch(const MapFeatures& a, const MapFeatures& b, const MatchParams& params,
                      const EvaluationParams& evaluation, MatchResult& result) {
  if (isEmpty(a, b)) return evaluateMatch(a, b, {}, result.T_a_b, evaluation);
  if (result.iterations.empty()) {  // a pose that was given
    const VoxelAssociation association = associationOf(a, b, params);
    result.covariance = covarianceOf(a, b, voxelLevel(a, b, association, params), result.T_a_b);
  }
  const PoseDeviation deviation =
      deviationAt(result.covariance, result.T_a_b * meanOf(b.matched.voxels.centre));
  const auto judge = [&] {
    return evaluateMatch(a, b, result.pairs, result.T_a_b, evaluation, result.runnerUp(), deviation,
                         params.evaluation_voxels);
  };
  const Evaluation e = judge();
  const bool has_bounds = params.search.translation > 0 && !params.search.isEverywhere();
  if (has_bounds && e.accepted && e.probability < evaluation.sure_probability &&
      findBetterElsewhere(a, b, evaluation.max_runner_up, params, result))
    return judge();
  return e;
}

namespace {

/** Whether a map has seen free space at a point. */
bool isFree(const MapVoxels& map, const Eigen::Vector3d& p) {
  octomap::OcTreeKey key;
  return map.map->coordToKeyChecked(p.x(), p.y(), p.z(), key) && map.free.has(key);
}

/** Beyond the thickness of a surface, and of what two grids make of it, in voxels. */
constexpr double kBeforeSurface = 2.5;

/** What a map says of another's obstacles: so many confirmed, and so many in its free space. */
struct Testimony {
  double confirmed = 0, contradicted = 0;
};

Testimony testimonyOf(const MapVoxels& map, const Obstacles& obstacles, double resolution,
                      const Eigen::Isometry3d& T) {
  constexpr double kOtherSide = 0.05;  // of an obstacle seen from the same side
  const double before = kBeforeSurface * std::max(resolution, map.voxels.resolution);
  Testimony t;
  for (size_t i = 0; i < obstacles.centre.size(); i++) {
    const Eigen::Vector3d centre = obstacles.centre[i].cast<double>();
    const Finding finding = findingAt(map, T * centre);
    if (finding == Finding::Agrees) {
      const Eigen::Vector3d front = obstacles.front[i].cast<double>();
      const bool same_side = front.isZero(0) || isFree(map, T * (centre + before * front));
      t.confirmed += same_side ? 1 : kOtherSide;
    } else if (finding == Finding::Conflicts) {
      t.contradicted++;
    }
  }
  return t;
}

}  // namespace

Obstacles obstaclesOf(const MapVoxels& map, const SurfaceVoxels& voxels) {
  Obstacles obstacles{voxels.voxels.centre, voxels.surfaces.normal};
  const double before = kBeforeSurface * voxels.voxels.resolution;
  for (size_t i = 0; i < obstacles.centre.size(); i++) {
    Eigen::Vector3f& front = obstacles.front[i];
    const Eigen::Vector3d centre = obstacles.centre[i].cast<double>();
    const Eigen::Vector3d step = before * front.cast<double>();
    const bool ahead = isFree(map, centre + step), behind = isFree(map, centre - step);
    if (ahead == behind)
      front.setZero();
    else if (behind)
      front = -front;
  }
  return obstacles;
}

double agreement(const MapVoxels& a, const Obstacles& of_a, const MapVoxels& b,
                 const Obstacles& of_b, const Eigen::Isometry3d& T_a_b) {
  constexpr double kTolerance = 0.02;
  const Testimony by_a = testimonyOf(a, of_b, b.voxels.resolution, T_a_b);
  const Testimony by_b = testimonyOf(b, of_a, a.voxels.resolution, T_a_b.inverse());
  const double confirmed = by_a.confirmed + by_b.confirmed;
  const double contradicted = by_a.contradicted + by_b.contradicted;
  if (confirmed == 0) return 0;
  return confirmed * std::exp(-contradicted / (confirmed + contradicted) / kTolerance);
}

Pairs pairVoxels(const MapVoxels& a, const MapVoxels& b, const Eigen::Isometry3d& T_a_b,
                 const MatchParams& params) {
  const size_t n = b.voxels.size();
  if (a.voxels.size() == 0 || n == 0) return {};
  VoxelAssociation association(a.voxels, a.occupied);
  association.prepare(params.voxel_level.gate);
  const double H_m = occupancyUncertainty(a.voxels.probability, b.voxels.probability);
  Pairs asked;
  const size_t stride = strideFor(n, params.evaluation_voxels);
  for (size_t i = 0; i < n; i += stride) asked.push_back({0, static_cast<uint32_t>(i), 0});
  return firstPairs(voxelPairing(b.voxels, H_m, association, params), T_a_b,
                    params.voxel_level.gate, &asked);
}

}  // namespace mrpt::fusion
