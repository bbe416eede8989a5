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
 * The paper's Sec. IV-B: which voxel of B belongs to which voxel of A.
 *
 * A is the paper's model, B its scene; B is moved by T_a_b. */

namespace mrpt::fusion {

/** Eq. (15): mean of -p ln p over the voxels of both maps, nats: the uncertainty of the occupancy
 * probabilities. One term of Shannon's entropy, as published: largest at p = 1/e, 0 at p = 1. */
double occupancyUncertainty(const std::vector<float>& probability_a,
                            const std::vector<float>& probability_b);

/** Eq. (16): mean of lambda_3 / (lambda_1 + lambda_2 + lambda_3) over the edges of both maps; 1 for
 * perfect lines, 1/3 for no direction at all. */
double structuralUncertainty(const EdgeVoxels& a, const EdgeVoxels& b);

/** Mean squared Euclidean distance of the pairs (the paper's MSE), m^2; 0 for none. */
double meanSquaredError(const Pairs& pairs);

/** Weights of the squared occupancy and direction differences beside the squared distance, m^2. */
struct DescriptorWeights {
  double omega_o = 0;    ///< of the occupancy difference, m^2
  double omega_tau = 0;  ///< of the direction difference, m^2
};

/** Eqs. (17)-(20): omega_o = k1 MSE / H_m, omega_tau = k2 MSE lambda_tau.
 * \param[in] mse See meanSquaredError(), m^2. \param[in] params k1 and k2. \param[in] H_m Eq. (15);
 * at 0 (all voxels certain) it is taken as 1e-3, so that omega_o stays finite. \param[in]
 * lambda_tau Eq. (16); 0 at the voxel level, which has no directions. */
DescriptorWeights descriptorWeights(double mse, double H_m, double lambda_tau,
                                    const WeightParams& params);

/** Finds pairs by eq. (14): the 4-D descriptor {x, y, z, p}. Built once for a map A, which must
 * outlive it; building is O(n), associating costs what lies within the pairs' distances. On all
 * cores with the same result for any number of them. The gate is on the square root of the eq.'s
 * distance, in metres (Table I). */
class VoxelAssociation {
 public:
  /** \param[in] a Not owned, must outlive this. */
  explicit VoxelAssociation(const OccupiedVoxels& a);
  /** \overload
   * With \a blocks of A's keys, not owned either: saves building them. */
  VoxelAssociation(const OccupiedVoxels& a, const VoxelBlocks& blocks);
  ~VoxelAssociation();
  VoxelAssociation(VoxelAssociation&&) noexcept;  ///< the other can but be destroyed

  /** Makes ready for gates up to this one, m. */
  void prepare(double gate);

  /** What was found for a voxel of B. */
  struct Partner {
    uint32_t a = ~uint32_t{0};                        ///< the largest number: none
    float others = -1;                                ///< all other voxels of A are as far, m
    Eigen::Vector3f place = Eigen::Vector3f::Zero();  ///< from there, m, A's frame
  };
  using Partners = std::vector<Partner>;  ///< of each voxel of B; empty at first
  /** The nearest voxel of A by eq. (14) of each voxel of B, if it is near enough.
   * \param[in] b Map B's voxels. \param[in] T_a_b Pose of map B in A's frame.
   * \param[in] weights Of the descriptor's parts. \param[in] gate Largest distance, m.
   * \param[in] among The pairs whose voxels of B to pair; null: all.
   * \param[in,out] last Of the same voxels of B at a pose nearby: saves time, changes nothing. */
  Pairs associate(const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                  const DescriptorWeights& weights, double gate, const Pairs* among = nullptr,
                  Partners* last = nullptr);
  /** \overload
   * By several threads at once, each with partners of its own. \exception std::logic_error If the
   * gate is wider than what has been prepared for. */
  Pairs associate(const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                  const DescriptorWeights& weights, double gate, const Pairs* among = nullptr,
                  Partners* last = nullptr) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Finds pairs of edge voxels by eq. (13): the 7-D descriptor {x, y, z, p, tau}, of which tau and
 * -tau are the same direction. Building is O(n log n), associating about O(m log n); otherwise as
 * VoxelAssociation. */
class EdgeAssociation {
 public:
  /** \param[in] a Not owned, must outlive this. */
  explicit EdgeAssociation(const EdgeVoxels& a);
  ~EdgeAssociation();
  EdgeAssociation(EdgeAssociation&&) noexcept;  ///< the other can but be destroyed

  /** The nearest voxel of A by eq. (13), as VoxelAssociation::associate(). */
  Pairs associate(const EdgeVoxels& b, const Eigen::Isometry3d& T_a_b,
                  const DescriptorWeights& weights, double gate, const Pairs* among = nullptr);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mrpt::fusion
