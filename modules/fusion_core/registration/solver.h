// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/registration_params.h>

#include <Eigen/Geometry>

#include "fusion_core/registration/normal_equations.h"

/** \file
 * The paper's Sec. IV-C: optimises the pose for given pairs.
 *
 * Poses are perturbed on the left, in A's frame, about the mean c of the pairs:
 * `T <- Tr(c) exp(xi) Tr(-c) T`, xi = (translation, rotation). The rotation about c keeps the
 * equations well conditioned if the maps lie far from the origins of their frames. */

namespace mrpt::fusion {

/** Returns exp of a twist. The first 3 elements are the translation part (the translation is
 * V xi_t), the last 3 are the rotation vector, rad. */
Eigen::Isometry3d expSE3(const Vector6d& xi);

/** Minimises an error by Levenberg-Marquardt on SE(3). Directions that the pairs do not constrain
 * do not change. Cost per step: one error, and one linearisation unless the previous step was
 * rejected.
 * \param[in] T Start.
 * \param[in] params Settings of the solver.
 * \param[in] linearize The linearisation: (T) -> NormalEquations.
 * \param[in] errorAt The error: (T) -> double.
 * \return The pose. Its error is never larger than the error at \a T. */
template <class Linearize, class ErrorAt>
Eigen::Isometry3d optimizePose(Eigen::Isometry3d T, const SolverParams& params,
                               Linearize&& linearize, ErrorAt&& errorAt);

/** Returns T perturbed by xi about a centre. */
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
