// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/registration_params.h>
#include <mrpt/fusion/voxels.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "fusion_core/map/voxel_blocks.h"

/** \file
 * The paper's Sec. IV-B: pairs voxels of B with voxels of A.
 *
 * The paper calls A the model and B the scene. B is moved by T_a_b. */

namespace mrpt::fusion {

/** Eq. (15): returns the uncertainty of the occupancy probabilities: the mean of -p ln p over the
 * voxels of both maps, nats. This is one term of Shannon's entropy, as published. It is largest at
 * p = 1/e and 0 at p = 1. */
double occupancyUncertainty(const std::vector<float>& probability_a,
                            const std::vector<float>& probability_b);

/** Eq. (16): returns the mean of lambda_3 / (lambda_1 + lambda_2 + lambda_3) over the edges of both
 * maps. It is 1 for perfect lines and 1/3 without directions. */
double structuralUncertainty(const EdgeVoxels& a, const EdgeVoxels& b);

/** Returns the mean squared Euclidean distance of the pairs (the paper's MSE), m^2; 0 without
 * pairs. */
double meanSquaredError(const Pairs& pairs);

/** Weights of the squared occupancy and direction differences in the descriptor distance, m^2. */
struct DescriptorWeights {
  double omega_o = 0;    ///< Weight of the squared occupancy difference, m^2
  double omega_tau = 0;  ///< Weight of the squared direction difference, m^2
};

/** Eqs. (17)-(20): returns omega_o = k1 MSE / H_m and omega_tau = k2 MSE lambda_tau.
 * \param[in] mse See meanSquaredError(), m^2.
 * \param[in] H_m Eq. (15). Values below 1e-3 count as 1e-3, so that omega_o stays finite if all
 * voxels are certain.
 * \param[in] lambda_tau Eq. (16); 0 at the voxel level, which has no directions.
 * \param[in] params Factors k1 and k2. */
DescriptorWeights descriptorWeights(double mse, double H_m, double lambda_tau,
                                    const WeightParams& params);

/** Finds pairs by eq. (14): the 4-D descriptor {x, y, z, p}. It is built once for a map A. The gate
 * limits the square root of the distance of eq. (14), m (Table I). The result does not depend on
 * the number of threads. Cost: O(n) to build; an association costs the number of voxels within the
 * distances of the pairs. */
class VoxelAssociation {
 public:
  /** \param[in] a Voxels of A. Not owned; must outlive the association. */
  explicit VoxelAssociation(const OccupiedVoxels& a);
  /** \overload
   * Uses an existing index \a blocks of A's keys. Not owned; must outlive the association. */
  VoxelAssociation(const OccupiedVoxels& a, const VoxelBlocks& blocks);
  ~VoxelAssociation();
  VoxelAssociation(VoxelAssociation&&) noexcept;  ///< Leaves the source fit only for destruction

  /** Prepares for gates up to \a gate, m. */
  void prepare(double gate);

  /** Result of the last search for a voxel of B. */
  struct Partner {
    uint32_t a = ~uint32_t{0};  ///< Index of the partner; largest number: none
    float others = -1;          ///< Lower bound on the distance from place to other voxels, m
    Eigen::Vector3f place = Eigen::Vector3f::Zero();  ///< Place of the search, m, A's frame
  };
  using Partners = std::vector<Partner>;  ///< Partner of each voxel of B; empty at first
  /** Pairs each voxel of B with the nearest voxel of A by eq. (14), if it lies within the gate.
   * \param[in] b Voxels of B.
   * \param[in] T_a_b Pose of map B in A's frame.
   * \param[in] weights Weights of the descriptor.
   * \param[in] gate Largest descriptor distance, m.
   * \param[in] among Pairs whose voxels of B are paired; null: all voxels of B.
   * \param[in,out] last Partners of the same voxels of B at a similar pose. They save time and do
   * not change the result. */
  Pairs associate(const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                  const DescriptorWeights& weights, double gate, const Pairs* among = nullptr,
                  Partners* last = nullptr);
  /** \overload
   * Several threads may call it at once, each with its own partners.
   * \exception std::logic_error If the gate is wider than prepared. */
  Pairs associate(const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                  const DescriptorWeights& weights, double gate, const Pairs* among = nullptr,
                  Partners* last = nullptr) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Finds pairs of edge voxels by eq. (13): the 7-D descriptor {x, y, z, p, tau}. tau and -tau are
 * the same direction. Cost: O(n log n) to build, about O(m log n) for an association of m voxels.
 * The gate is as for VoxelAssociation. */
class EdgeAssociation {
 public:
  /** \param[in] a Edge voxels of A; copied. */
  explicit EdgeAssociation(const EdgeVoxels& a);
  ~EdgeAssociation();
  EdgeAssociation(EdgeAssociation&&) noexcept;  ///< Leaves the source fit only for destruction

  /** Pairs voxels by eq. (13), see VoxelAssociation::associate(). */
  Pairs associate(const EdgeVoxels& b, const Eigen::Isometry3d& T_a_b,
                  const DescriptorWeights& weights, double gate, const Pairs* among = nullptr);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mrpt::fusion
