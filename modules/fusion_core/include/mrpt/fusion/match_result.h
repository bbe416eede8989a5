// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

/** \file
 * The result of matching: pose, covariance, pairs, hypotheses. */

namespace mrpt::fusion {

using Matrix6d =
    Eigen::Matrix<double, 6, 6>;  ///< Matrix of a perturbation (translation, rotation): m, rad
using Vector6d = Eigen::Matrix<double, 6, 1>;  ///< Perturbation: translation, m; rotation, rad

/** Variance of an unknown direction, m^2 or rad^2. */
constexpr double kUnknownVariance = 1e6;

/** Standard deviations of a pose, each in its least certain direction. */
struct PoseDeviation {
  double translation = 0;  ///< Standard deviation of a point, m
  double rotation = 0;     ///< Standard deviation of the rotation, rad
  /** Principal directions of the error of the point: unit columns in A's frame, the least certain
   * direction first. Zero if they are not known. */
  Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();
  /** Principal axes of the error of the rotation, as directions. */
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
  unsigned free_directions = 0;  ///< Number of first directions along which map B slides freely
  unsigned free_axes = 0;        ///< Number of first axes about which map B turns freely
};

/** Measured size of map B over the size of map A. It is 1 if both maps have the same unit. */
struct SizeRatio {
  double value = 1;                                            ///< Size of B over size of A
  double deviation = std::numeric_limits<double>::infinity();  ///< Its standard deviation
};

/** A voxel of B and the nearest voxel of A by descriptor. */
struct Pair {
  uint32_t a;              ///< Index into A's voxels
  uint32_t b;              ///< Index into B's voxels
  float squared_distance;  ///< Squared Euclidean distance of the centres, m^2
};
using Pairs = std::vector<Pair>;  ///< Pairs, at most one for each voxel of B

/** Levels of registration, in their order. */
enum class Level {
  Edge = 1,  ///< Structural edges, eq. (21)
  Voxel = 2  ///< Occupied voxels, eq. (22)
};

/** Record of one iteration: an association and the optimisation after it. */
struct IterationRecord {
  Level level;              ///< Level of the iteration
  size_t pairs;             ///< Number of associated pairs
  double mse;               ///< Mean squared distance of these pairs, m^2
  double step_translation;  ///< Step of the mean of B's voxels in this level, m
  double step_rotation;     ///< Rotation of the step, rad
  Eigen::Isometry3d T_a_b;  ///< Pose after the iteration
};
using OnIteration = std::function<void(const IterationRecord&)>;  ///< Called after an iteration

/** A hypothesis: a pose that was compared with other poses. */
struct RankedPose {
  Eigen::Isometry3d T_a_b;  ///< Pose of map B in A's frame
  double agreement;         ///< Agreement of the maps at the pose, see agreement()
  /** Covariance as MatchResult::covariance, from the few voxels of the comparison.
   * kUnknownVariance in all directions if the agreement is below
   * RankingParams::min_rival_agreement times the agreement of the best pose. */
  Matrix6d covariance;
};

/** The result of matching. It is the only place of pose, covariance and hypotheses; Alignment
 * converts them to MRPT's types. */
struct MatchResult {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< Pose of map B in A's frame
  /** Covariance of a left perturbation (translation, rotation) of the pose, in A's frame, m and
   * rad. Initially kUnknownVariance in all directions. */
  Matrix6d covariance = kUnknownVariance * Matrix6d::Identity();
  SizeRatio size_ratio;                     ///< Size of B over size of A at the pose
  std::vector<IterationRecord> iterations;  ///< Records of both levels, in their order
  /** Distinct poses that were compared, best agreement first. Empty without a search. The first
   * hypothesis is T_a_b before the registration with all voxels. Two kinds of poses are second for
   * any agreement: a pose that a wider search found, and the best pose by few voxels if the
   * registration with all voxels moved far from it. */
  std::vector<RankedPose> hypotheses;
  /** Agreement of the second hypothesis over the agreement of the first; 0 without a second
   * hypothesis, at most kMostRunnerUp. Above 1 only for the two kinds of second poses that
   * \a hypotheses describes. */
  double runnerUp() const {
    if (hypotheses.size() < 2 || hypotheses[1].agreement <= 0) return 0;
    return std::min(hypotheses[1].agreement / std::max(hypotheses[0].agreement, 0.0),
                    kMostRunnerUp);
  }
  static constexpr double kMostRunnerUp = 1e6;  ///< Ratio beside a pose without any agreement
  Pairs pairs;                                  ///< Pairs at T_a_b of the voxels in the verdict
  /** Least number of pairs that determines a pose. A level stops below this number. */
  static constexpr size_t kMinPairs = 10;
  /** True if the pairs determine a pose. */
  bool hasPairs() const { return pairs.size() >= kMinPairs; }
};

}  // namespace mrpt::fusion
