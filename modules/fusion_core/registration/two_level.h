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

/** The pairing of the voxel level, eq. (14). The verdict on a given pose needs only this part. */
class VoxelPairing : public Pairing {
 public:
  /** All arguments except H_m are not owned and must outlive the pairing.
   * \param[in] b Voxels of B.
   * \param[in] H_m See occupancyUncertainty().
   * \param[in] association Association of A's voxels, prepared for all gates used.
   * \param[in] params Factors of the weights. */
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
  /** Returns the mean occupancy uncertainty of the maps, see occupancyUncertainty(). */
  double H_m() const { return H_m_; }

 private:
  const OccupiedVoxels& b_;
  const double H_m_;
  const VoxelAssociation& association_;
  const WeightParams& params_;
  VoxelAssociation::Partners last_;
};

/** The voxel level, eq. (22). It refers to its arguments, which must outlive it. */
class VoxelLevel : public LevelProblem {
 public:
  /** \param[in] a,b Voxels of the maps A and B.
   * \param[in] H_m See occupancyUncertainty().
   * \param[in] association Association of A's voxels, prepared for all gates used.
   * \param[in] params Settings of registration. */
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

  /** Returns the scatter of the gradients at a pose, about a centre, m. */
  GradientScatter scatter(const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                          const Eigen::Vector3d& centre) const;
  /** Returns the mean occupancy uncertainty of the maps, see occupancyUncertainty(). */
  double H_m() const { return pairing_.H_m(); }
  /** Returns the covariance of the errors of both grids, see commonCovariance().
   * \param[in] pairs The pairs.
   * \param[in] centre Middle of the pairs, m, A's frame. */
  Matrix6d commonCovariance(const Pairs& pairs, const Eigen::Vector3d& centre) const;

 private:
  const SurfaceVoxels &a_, &b_;
  const RegistrationParams& params_;
  Eigen::Vector3d middle_;
  VoxelPairing pairing_;
};

/** Runs the edge level from result.T_a_b. Changes the pose and the iterations of the result. */
void matchEdges(const MapFeatures& a, const MapFeatures& b, const RegistrationParams& params,
                MatchResult& result, const OnIteration& on_iteration);

/** Runs the voxel level from result.T_a_b, and computes the covariance and the pairs of the result.
 * \param[in] a,b Features of the maps A and B.
 * \param[in] association See associationOf().
 * \param[in] first_gate Gate of the first iteration, m.
 * \param[in] params Settings of registration.
 * \param[in] voxels See pairVoxels().
 * \param[in,out] result Holds the start; receives pose, iterations, covariance and pairs.
 * \param[in] on_iteration Called after each iteration, if given. */
void matchVoxels(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                 double first_gate, const RegistrationParams& params, size_t voxels,
                 MatchResult& result, const OnIteration& on_iteration);

/** Returns the association of A's matched voxels, prepared for all gates of the voxel level and of
 * its covariance. Threads may share it. */
VoxelAssociation associationOf(const MapFeatures& a, const MapFeatures& b,
                               const RegistrationParams& params);

/** Returns the voxel level with all matched voxels of the maps. */
VoxelLevel voxelLevel(const MapFeatures& a, const MapFeatures& b,
                      const VoxelAssociation& association, const RegistrationParams& params);

/** Returns the covariance of a pose from the pairs of a level at that pose, see
 * MatchResult::covariance. */
Matrix6d covarianceOf(const MapFeatures& a, const MapFeatures& b, VoxelLevel& level,
                      const Eigen::Isometry3d& T_a_b, const RegistrationParams& params);

/** Returns the least gate of voxel pairs, m. */
double leastVoxelGate(const MapFeatures& a, const MapFeatures& b, const RegistrationParams& params);

/** Returns the voxel pairs at a given pose, with the weights and the gate of the first iteration of
 * the voxel level. The verdict judges these pairs.
 * \param[in] a,b The maps A and B.
 * \param[in] T_a_b Pose of map B in A's frame.
 * \param[in] params Settings of registration.
 * \param[in] voxels Number of B's voxels to pair, spread evenly, see strideFor(). */
Pairs pairVoxels(const MapVoxels& a, const MapVoxels& b, const Eigen::Isometry3d& T_a_b,
                 const RegistrationParams& params, size_t voxels);

/** Eqs. (10)-(12): estimates the pose of map B in A's frame from a guess. It aligns B's edges with
 * A's edges, then B's voxels with A's voxels.
 *
 * This is a local optimiser: it finds the nearest minimum, which may be a wrong pose. The verdict
 * checks the pose. Without pairs within the gates it returns the guess and no pairs. The result
 * does not depend on the number of threads. Cost: iterations * voxels of B * log(voxels of A).
 * \param[in] a,b Features of the maps A and B.
 * \param[in] T_a_b The guess.
 * \param[in] params Settings; all fields are used.
 * \param[in] voxels Number of B's voxels to pair at the end, see pairVoxels().
 * \param[in] on_iteration Called after each iteration, if given (progress, plots). Never called by
 * two threads at a time, but not always by the same thread. */
MatchResult matchTwoLevel(const MapFeatures& a, const MapFeatures& b,
                          const Eigen::Isometry3d& T_a_b, const RegistrationParams& params,
                          size_t voxels, const OnIteration& on_iteration = {});

}  // namespace mrpt::fusion
