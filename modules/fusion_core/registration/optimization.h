// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "fusion_core/registration/association.h"

/** \file
 * The paper's Sec. IV-C: the pose that brings the pairs together.
 *
 * Poses are perturbed on the left, in A's frame, about the middle c of the pairs:
 * `T <- Tr(c) exp(xi) Tr(-c) T`, xi = (translation, rotation). Turning about the pairs themselves
 * keeps the equations well conditioned however far the maps lie from their frames' origins. */

namespace mrpt::fusion {

using Matrix6d = Eigen::Matrix<double, 6, 6>;  ///< of a perturbation: m, rad
using Vector6d = Eigen::Matrix<double, 6, 1>;  ///< a perturbation: translation, m; rotation, rad

/** The normal equations of one linearisation: sum of e' W e = error - 2 g' xi + xi' H xi. */
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();                     ///< Hessian
  Vector6d g = Vector6d::Zero();                     ///< right-hand side: H xi = g
  double error = 0;                                  ///< sum of squared Mahalanobis distances
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< c, m

  /** The same equations for steps about another centre, m. */
  NormalEquations about(const Eigen::Vector3d& other) const;
};

/** How the pairs of one patch of the scene, a cube of some side, together pull at the pose: the
 * scatter of the patches' gradients. What two maps get wrong they get wrong for a whole piece of
 * wall (drift, a door ajar), so the pairs of a patch are not independent; patches nearly are. */
struct GradientScatter {
  Matrix6d S = Matrix6d::Zero();  ///< sum of g g' over the patches, about the same centre as H
  size_t patches = 0;             ///< number of them
};

/** Eq. (21), the edge level: e = m - T s, W = (Sigma_m + R Sigma_s R')^-1 with the fused
 * covariances of eq. (9). */
NormalEquations linearizeEdges(const EdgeVoxels& model, const EdgeVoxels& scene, const Pairs& pairs,
                               const Eigen::Isometry3d& T_a_b, VoxelCovariance kind);

/** NormalEquations::error of linearizeEdges() alone. */
double edgeError(const EdgeVoxels& model, const EdgeVoxels& scene, const Pairs& pairs,
                 const Eigen::Isometry3d& T_a_b, VoxelCovariance kind);

/** Eq. (22), the voxel level: W = (1/p_m + 1/p_s)^-1 I. */
NormalEquations linearizeVoxels(const OccupiedVoxels& model, const OccupiedVoxels& scene,
                                const Pairs& pairs, const Eigen::Isometry3d& T_a_b);
/** NormalEquations::error of linearizeVoxels() alone. */
double voxelError(const OccupiedVoxels& model, const OccupiedVoxels& scene, const Pairs& pairs,
                  const Eigen::Isometry3d& T_a_b);

/** The voxel level with directions (not in the paper, after Segal et al., "Generalized-ICP"): a
 * voxel with a normal is a piece of surface, well known across it and hardly along it. W is eq.
 * (22)'s factor times (C_m + R C_s R')^-1, C = I - (1 - flatness) n n', so that surfaces slide
 * along each other; voxels without a normal have C = I. e is between the surfaces' points, not the
 * voxels' centres. A scene voxel that stands for several (Surfaces::weight) counts as so many.
 * The surfaces hold one piece per voxel. */
NormalEquations linearizeSurfaces(const OccupiedVoxels& model, const Surfaces& model_surface,
                                  const OccupiedVoxels& scene, const Surfaces& scene_surface,
                                  const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                                  double flatness);
/** NormalEquations::error of linearizeSurfaces() alone. */
double surfaceError(const OccupiedVoxels& model, const Surfaces& model_surface,
                    const OccupiedVoxels& scene, const Surfaces& scene_surface, const Pairs& pairs,
                    const Eigen::Isometry3d& T_a_b, double flatness);

/** The gradients of linearizeVoxels(), by patches of the scene: cubes of a \a side (m), about the
 * \a centre of the normal equations (m). */
GradientScatter scatterVoxels(const OccupiedVoxels& model, const OccupiedVoxels& scene,
                              const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                              const Eigen::Vector3d& centre, double side);
/** The same of linearizeSurfaces(). */
GradientScatter scatterSurfaces(const OccupiedVoxels& model, const Surfaces& model_surface,
                                const OccupiedVoxels& scene, const Surfaces& scene_surface,
                                const Pairs& pairs, const Eigen::Isometry3d& T_a_b, double flatness,
                                const Eigen::Vector3d& centre, double side);

/** Standard deviations of a pose, each in the direction that is known least. */
struct PoseDeviation {
  double translation = 0;  ///< of a point, m
  double rotation = 0;     ///< rad
};

/** The largest standard deviation of where a point comes to lie, and of the rotation.
 * \param[in] covariance As poseCovariance(). \param[in] point Where it lies, m, A's frame. */
PoseDeviation deviationAt(const Matrix6d& covariance, const Eigen::Vector3d& point);

/** exp of a twist (translation part first, as V xi_t; rotation as a vector, rad). */
Eigen::Isometry3d expSE3(const Vector6d& xi);

/** Settings of optimizePose(). */
struct SolverParams {
  unsigned max_steps = 10;        ///< Levenberg-Marquardt steps for one set of pairs
  double min_translation = 1e-5;  ///< stop below this step, m
  double min_rotation = 1e-5;     ///< and this, rad
};

/** Levenberg-Marquardt on SE(3): minimises the error that \a linearize (T -> NormalEquations) and
 * \a errorAt (T -> double) give. Directions that the pairs do not constrain are left as they are.
 * Cost: an error a step, and a linearisation unless the step before it was not taken.
 * \return The pose; never one of a larger error than \a T. */
template <class Linearize, class ErrorAt>
Eigen::Isometry3d optimizePose(Eigen::Isometry3d T, const SolverParams& params,
                               Linearize&& linearize, ErrorAt&& errorAt);

/** T perturbed by xi about a centre. */
Eigen::Isometry3d perturb(const Eigen::Isometry3d& T, const Vector6d& xi,
                          const Eigen::Vector3d& centre);

/** The covariance of a left perturbation of the pose about the origin of A's frame, from the
 * equations at the optimum: s^2 H^-1 with the residual variance s^2 = error / (3 pairs - 6), and,
 * for what whole patches have in common, H^-1 S H^-1 (the sandwich estimator of clustered data,
 * e.g. Cameron and Miller 2015), which few patches make unsure: with n of them 6 / (6 + n) of it is
 * spread as H^-1 is. Directions with no information get \a unknown_variance. */
Matrix6d poseCovariance(const NormalEquations& at_optimum, size_t pairs,
                        const GradientScatter& scatter = {}, double unknown_variance = 1e6);

// ------------------------------------------------------------------------------------------------

/** Solves (H + lambda diag H) xi = g in the subspace that the pairs constrain. */
Vector6d solveDamped(const NormalEquations& equations, double lambda);

template <class Linearize, class ErrorAt>
Eigen::Isometry3d optimizePose(Eigen::Isometry3d T, const SolverParams& params,
                               Linearize&& linearize, ErrorAt&& errorAt) {
  double lambda = 1e-6;
  NormalEquations equations;
  bool is_linearized = false;
  for (unsigned step = 0; step < params.max_steps; step++) {
    if (!is_linearized) equations = linearize(T);
    is_linearized = true;
    const Vector6d xi = solveDamped(equations, lambda);
    if (xi.head<3>().norm() < params.min_translation && xi.tail<3>().norm() < params.min_rotation)
      break;
    const Eigen::Isometry3d candidate = perturb(T, xi, equations.centre);
    if (errorAt(candidate) <= equations.error) {
      T = candidate;
      is_linearized = false;
      lambda *= 0.1;
    } else {
      lambda = lambda < 1e-3 ? 1e-3 : 10 * lambda;
      if (lambda > 1e6) break;
    }
  }
  return T;
}

}  // namespace mrpt::fusion
