// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/registration_params.h>

#include <Eigen/Geometry>

#include "fusion_core/registration/normal_equations.h"

/** \file
 * The paper's Sec. IV-C: the pose that brings the pairs together.
 *
 * Poses are perturbed on the left, in A's frame, about the middle c of the pairs:
 * `T <- Tr(c) exp(xi) Tr(-c) T`, xi = (translation, rotation). Turning about the pairs themselves
 * keeps the equations well conditioned however far the maps lie from their frames' origins. */

namespace mrpt::fusion {

/** exp of a twist (translation part first, as V xi_t; rotation as a vector, rad). */
Eigen::Isometry3d expSE3(const Vector6d& xi);

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
