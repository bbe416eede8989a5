// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

/** \file
 * What matching finds: pose, covariance, pairs, rivals. */

namespace mrpt::fusion {

using Matrix6d =
    Eigen::Matrix<double, 6, 6>;  ///< Of a perturbation (translation, rotation): m, rad
using Vector6d = Eigen::Matrix<double, 6, 1>;  ///< A perturbation: translation, m; rotation, rad

/** Variance of a direction of which nothing is known, m^2 or rad^2. */
constexpr double kUnknownVariance = 1e6;

/** Standard deviations of a pose, each in the direction that is known least. */
struct PoseDeviation {
  double translation = 0;  ///< Of a point, m
  double rotation = 0;     ///< rad
};

/** A voxel of B and the voxel of A that is nearest to it by descriptor. */
struct Pair {
  uint32_t a;              ///< Index into A's voxels
  uint32_t b;              ///< Index into B's voxels
  float squared_distance;  ///< Between the centres, Euclidean, m^2
};
using Pairs = std::vector<Pair>;  ///< At most one pair for each voxel of B

/** The levels of matching, in their order. */
enum class Level {
  Edge = 1,  ///< Structural edges, eq. (21)
  Voxel = 2  ///< Occupied voxels, eq. (22)
};

/** One iteration: an association and the optimisation that follows it. */
struct IterationRecord {
  Level level;              ///< Level of the iteration
  size_t pairs;             ///< Number of associated pairs
  double mse;               ///< Mean squared distance of these pairs, m^2
  double step_translation;  ///< Step of the middle of B's voxels of this level, m
  double step_rotation;     ///< Rotation of the step, rad
  Eigen::Isometry3d T_a_b;  ///< Pose that the iteration reached
};
using OnIteration = std::function<void(const IterationRecord&)>;  ///< Called after an iteration

/** A hypothesis: a pose that was compared with others. */
struct RankedPose {
  Eigen::Isometry3d T_a_b;  ///< Pose of map B in A's frame
  double agreement;         ///< How well the maps agree there, see agreement()
  /** As MatchResult::covariance, from the few voxels that the pose was refined on.
   * kUnknownVariance in all directions if the maps agree less than 0.05 times as well as at the
   * best pose. */
  Matrix6d covariance;
};

/** What matching found. The only place where pose, covariance and hypotheses are kept; MRPT's
 * types are made of these, see Alignment. */
struct MatchResult {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< Pose of map B in A's frame
  /** Covariance of a left perturbation (translation, rotation) of the pose, in A's frame;
   * kUnknownVariance in all directions as long as nothing is known. */
  Matrix6d covariance = kUnknownVariance * Matrix6d::Identity();
  std::vector<IterationRecord> iterations;  ///< Iterations of both levels, in their order
  /** The distinct poses that were compared, best agreement first. The first is T_a_b before all
   * voxels refined it. Empty without a search. Two kinds of poses are second whatever their
   * agreement: a pose that verify() found elsewhere, and the pose that few voxels preferred if all
   * voxels led away from it. */
  std::vector<RankedPose> hypotheses;
  /** Agreement of the second hypothesis over that of the first; 0 if there is none. Above 1 only if
   * the second is of the two kinds named at hypotheses. */
  double runnerUp() const {
    return hypotheses.size() > 1 && hypotheses[0].agreement > 0
               ? hypotheses[1].agreement / hypotheses[0].agreement
               : 0;
  }
  Pairs pairs;  ///< Pairs of voxels at T_a_b, of the voxels that the verdict asks
  /** Least number of pairs that determines a pose; no level goes on with fewer. */
  static constexpr size_t kMinPairs = 10;
  /** True if there are enough pairs to determine a pose. */
  bool hasPairs() const { return pairs.size() >= kMinPairs; }
};

}  // namespace mrpt::fusion
