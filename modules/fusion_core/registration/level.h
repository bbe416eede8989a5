// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/registration_params.h>

#include <Eigen/Geometry>
#include <cstddef>

#include "fusion_core/registration/association.h"
#include "fusion_core/registration/normal_equations.h"

/** \file
 * A level of matching: association and optimisation by turns, until the pose stays. */

namespace mrpt::fusion {

/** How voxels of B are paired with voxels of A. May keep what it found for the next pose nearby, so
 * each thread has its own. */
class Pairing {
 public:
  virtual ~Pairing() = default;
  /** Number of B's voxels. */
  virtual size_t size() const = 0;
  /** The pairs at a pose.
   * \param[in] gate Largest descriptor distance, m. \param[in] among The pairs whose voxels of B to
   * pair; null: all voxels. */
  virtual Pairs associate(const Eigen::Isometry3d& T_a_b, const DescriptorWeights& weights,
                          double gate, const Pairs* among) = 0;
  /** Eqs. (17)-(20). \param[in] mse Mean squared distance of the last pairs, m^2. */
  virtual DescriptorWeights weights(double mse) const = 0;
};

/** A level: how to pair, and what to minimise. */
class LevelProblem : public Pairing {
 public:
  /** Which level it is. */
  virtual Level level() const = 0;
  /** Middle of B's voxels, m, B's frame. */
  virtual Eigen::Vector3d middle() const = 0;
  /** Normal equations of the pairs at a pose. */
  virtual NormalEquations linearize(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) const = 0;
  /** NormalEquations::error alone. */
  virtual double error(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) const = 0;
};

/** The pairs at a pose. The weights need an MSE before there are pairs: it is that of the nearest
 * neighbours by distance alone, of some voxels.
 * \param[in] gate Largest descriptor distance, m. \param[in] enough Number of voxels for that MSE.
 * \param[in] among The pairs whose voxels of B to pair; null: all voxels. */
Pairs firstPairs(Pairing& pairing, const Eigen::Isometry3d& T_a_b, double gate, size_t enough,
                 const Pairs* among = nullptr);

/** Alternates association and optimisation until the pose stays.
 * \param[in] level Gates and iterations. \param[in] least_gate Least final gate, m.
 * \param[in,out] result Pose to start from; receives the pose reached and the iterations.
 * \param[in] on_iteration Called after each iteration, if given. \return The last pairs. */
Pairs runLevel(LevelProblem& problem, const LevelParams& level, double least_gate,
               const RegistrationParams& params, MatchResult& result,
               const OnIteration& on_iteration);

}  // namespace mrpt::fusion
