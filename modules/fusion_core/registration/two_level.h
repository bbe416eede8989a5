// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/registration_params.h>

#include <Eigen/Geometry>

#include "fusion_core/features/features.h"
#include "fusion_core/registration/level.h"

/** \file
 * The paper's Sec. IV-A: two-level probabilistic map matching (PMM), edges, then voxels. */

namespace mrpt::fusion {

/** How the voxel level pairs, eq. (14): all that judging a pose needs of it. */
class VoxelPairing : public Pairing {
 public:
  /** \param[in] b B's voxels. \param[in] H_m See occupancyUncertainty(). \param[in] association Of
   * A's voxels, prepared for the gates to come. None is owned, all must outlive this. */
  VoxelPairing(const OccupiedVoxels& b, double H_m, const VoxelAssociation& association,
               const WeightParams& params)
      : b_(b), H_m_(H_m), association_(association), params_(params) {}

  size_t size() const override { return b_.size(); }
  Pairs associate(const Eigen::Isometry3d& T_a_b, const DescriptorWeights& weights, double gate,
                  const Pairs* among) override {
    return association_.associate(b_, T_a_b, weights, gate, among, &last_);
  }
  DescriptorWeights weights(double mse) const override {
    return descriptorWeights(mse, H_m_, 0, params_);
  }

 private:
  const OccupiedVoxels& b_;
  const double H_m_;
  const VoxelAssociation& association_;
  const WeightParams& params_;
  VoxelAssociation::Partners last_;
};

/** The voxel level, eq. (22). Refers to what it is given, which must outlive it. */
class VoxelLevel : public LevelProblem {
 public:
  /** \param[in] a,b Voxels of the maps A and B. \param[in] H_m See occupancyUncertainty().
   * \param[in] association Of a's voxels, prepared for the gates to come. */
  VoxelLevel(const SurfaceVoxels& a, const SurfaceVoxels& b, double H_m,
             const VoxelAssociation& association, const RegistrationParams& params);

  size_t size() const override { return pairing_.size(); }
  Pairs associate(const Eigen::Isometry3d& T_a_b, const DescriptorWeights& weights, double gate,
                  const Pairs* among) override {
    return pairing_.associate(T_a_b, weights, gate, among);
  }
  DescriptorWeights weights(double mse) const override { return pairing_.weights(mse); }
  Level level() const override { return Level::Voxel; }
  Eigen::Vector3d middle() const override { return middle_; }
  NormalEquations linearize(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) const override;
  double error(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) const override;

  /** Scatter of the gradients at a pose, about a centre, m. */
  GradientScatter scatter(const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                          const Eigen::Vector3d& centre) const;
  /** Variance of a shift that all pairs have in common, m^2. */
  double commonVariance() const;

 private:
  const SurfaceVoxels &a_, &b_;
  const RegistrationParams& params_;
  Eigen::Vector3d middle_;
  VoxelPairing pairing_;
};

/** The edge level, from result.T_a_b on; changes pose and iterations. */
void matchEdges(const MapFeatures& a, const MapFeatures& b, const RegistrationParams& params,
                MatchResult& result, const OnIteration& on_iteration);

/** The voxel level from its gate \a first_gate (m) on, from result.T_a_b on; gives the result its
 * covariance and its pairs. \param[in] voxels See pairVoxels(). */
void matchVoxels(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                 double first_gate, const RegistrationParams& params, size_t voxels,
                 MatchResult& result, const OnIteration& on_iteration);

/** Association of A's matched voxels, ready for all gates of the voxel level and of its covariance:
 * threads may share it. */
VoxelAssociation associationOf(const MapFeatures& a, const MapFeatures& b,
                               const RegistrationParams& params);

/** The voxel level with all matched voxels of the maps. */
VoxelLevel voxelLevel(const MapFeatures& a, const MapFeatures& b,
                      const VoxelAssociation& association, const RegistrationParams& params);

/** Covariance of a pose by a level's pairs there, see MatchResult::covariance. */
Matrix6d covarianceOf(const MapFeatures& a, const MapFeatures& b, VoxelLevel& level,
                      const Eigen::Isometry3d& T_a_b, const RegistrationParams& params);

/** The least gate of voxel pairs, m. */
double leastVoxelGate(const MapFeatures& a, const MapFeatures& b, const RegistrationParams& params);

/** The voxel pairs at a given pose, weighted and gated as the voxel level begins: what the verdict
 * judges. \param[in] voxels Number of B's voxels to pair, spread evenly, see strideFor(). */
Pairs pairVoxels(const MapVoxels& a, const MapVoxels& b, const Eigen::Isometry3d& T_a_b,
                 const RegistrationParams& params, size_t voxels);

/** Eqs. (10)-(12): the pose of map B in A's frame that brings B's edges, then B's voxels, onto A's,
 * from an initial guess.
 *
 * A local optimiser: it finds the nearest minimum. Whether that is the right pose is for the
 * verdict to say. Without pairs within the gates it returns the guess and no pairs. Deterministic,
 * whatever the number of threads. \param[in] a,b Features of the maps A and B. \param[in] T_a_b The
 * guess. \param[in] params All of it. \param[in] voxels Number of B's voxels to pair at the end,
 * see pairVoxels(). \param[in] on_iteration Called after each iteration, if given (progress,
 * plots); never by two threads at a time, but not always by the same thread. Cost: iterations *
 * voxels of B * log(voxels of A). */
MatchResult matchTwoLevel(const MapFeatures& a, const MapFeatures& b,
                          const Eigen::Isometry3d& T_a_b, const RegistrationParams& params,
                          size_t voxels, const OnIteration& on_iteration = {});

}  // namespace mrpt::fusion
