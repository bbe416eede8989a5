// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/registration_params.h>

#include <Eigen/Geometry>
#include <cstddef>

#include "fusion_core/registration/association.h"
#include "fusion_core/registration/normal_equations.h"

/** \file
 * A level of registration: alternates association and optimisation until the pose converges. */

namespace mrpt::fusion {

/** Interface: pairs voxels of B with voxels of A. It may cache results for the next similar pose,
 * so each thread needs its own object. */
class Pairing {
 public:
  virtual ~Pairing() = default;
  /** Returns the number of B's voxels. */
  virtual size_t size() const = 0;
  /** Returns the pairs at a pose.
   * \param[in] T_a_b Pose of map B in A's frame.
   * \param[in] weights Weights of the descriptor.
   * \param[in] gate Largest descriptor distance, m.
   * \param[in] among Pairs whose voxels of B are paired; null: all voxels of B. */
  virtual Pairs associate(const Eigen::Isometry3d& T_a_b, const DescriptorWeights& weights,
                          double gate, const Pairs* among) = 0;
  /** Returns the weights of the descriptor, eqs. (17)-(20).
   * \param[in] mse Mean squared distance of the last pairs, m^2. */
  virtual DescriptorWeights weights(double mse) const = 0;
};

/** Interface of a level: pairing, and the error to minimise. */
class LevelProblem : public Pairing {
 public:
  /** Returns the level. */
  virtual Level level() const = 0;
  /** Returns the mean of B's voxels, m, B's frame. */
  virtual Eigen::Vector3d middle() const = 0;
  /** Returns the normal equations of the pairs at a pose. */
  virtual NormalEquations linearize(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) const = 0;
  /** Returns only NormalEquations::error. */
  virtual double error(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) const = 0;
};

/** Returns the pairs at a pose without earlier pairs. The weights need an MSE. It is computed from
 * the nearest neighbours of some voxels, by distance only.
 * \param[in] pairing The pairing.
 * \param[in] T_a_b Pose of map B in A's frame.
 * \param[in] gate Largest descriptor distance, m.
 * \param[in] enough Largest number of voxels for the MSE.
 * \param[in] among Pairs whose voxels of B are paired; null: all voxels of B. */
Pairs firstPairs(Pairing& pairing, const Eigen::Isometry3d& T_a_b, double gate, size_t enough,
                 const Pairs* among = nullptr);

/** Alternates association and optimisation until the pose converges.
 * \param[in] problem The level.
 * \param[in] level Gates and number of iterations.
 * \param[in] least_gate Least final gate, m.
 * \param[in] params Settings of gates, solver and convergence.
 * \param[in,out] result Holds the start; receives the final pose and the iterations.
 * \param[in] on_iteration Called after each iteration, if given.
 * \return The last pairs. */
Pairs runLevel(LevelProblem& problem, const LevelParams& level, double least_gate,
               const RegistrationParams& params, MatchResult& result,
               const OnIteration& on_iteration);

}  // namespace mrpt::fusion
