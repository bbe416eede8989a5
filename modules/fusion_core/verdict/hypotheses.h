// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/registration_params.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "fusion_core/features/features.h"
#include "fusion_core/registration/two_level.h"
#include "fusion_core/verdict/agreement.h"

/** \file
 * Poses compared with one another: which is the best, and which rivals it has. */

namespace mrpt::fusion {

/** What a comparison of poses depends on. */
struct ComparisonParams {
  RegistrationParams registration;  ///< How poses are refined
  RankingParams ranking;            ///< How finely, by how many voxels
  PoseTolerance tolerance;          ///< Poses nearer than this are the same place
  double spacing;                   ///< Width of the cubes that give one voxel each at most, m
};

/** Registration parameters for poses that are compared before they are known precisely. */
RegistrationParams roughly(RegistrationParams registration, const RankingParams& ranking);

/** Distance of two poses of map B, 1 at the tolerance: the larger part counts.
 * \param[in] middle Of B's voxels, m, B's frame. */
double distanceBetween(const Eigen::Isometry3d& T, const Eigen::Isometry3d& U,
                       const Eigen::Vector3d& middle, const PoseTolerance& tolerance);

/** Compares poses by some voxels of each map: refines them on these, and counts how well the maps
 * agree there. Refers to maps and association, which must outlive it. Several threads may use it.
 */
class PoseComparison {
 public:
  /** \param[in] a,b The maps. \param[in] association Of a's matched voxels. \param[in] voxels
   * Number of voxels of each map. */
  PoseComparison(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                 const ComparisonParams& params, size_t voxels);
  /** \overload
   * \param[in] few_b B's voxels, see voxelsOf(). */
  PoseComparison(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                 const ComparisonParams& params, size_t voxels, SurfaceVoxels few_b);

  /** The voxels of a map that a comparison by a number of voxels takes. */
  static SurfaceVoxels voxelsOf(const MapFeatures& map, const ComparisonParams& params,
                                size_t voxels);

  /** The poses that the starts lead to, best first; of poses at the same place only the best. */
  std::vector<RankedPose> ranked(const std::vector<Eigen::Isometry3d>& starts) const;
  /** As MatchResult::covariance, by these voxels. */
  Matrix6d covarianceAt(const Eigen::Isometry3d& T_a_b) const;
  /** How well the maps agree at a pose, see agreement(). */
  double agreementAt(const Eigen::Isometry3d& T_a_b) const;

 private:
  VoxelLevel level() const;
  RankedPose refined(const Eigen::Isometry3d& start) const;

  const MapFeatures &a_, &b_;
  const VoxelAssociation& association_;
  const ComparisonParams params_;
  const RegistrationParams rough_;
  SurfaceVoxels few_b_;
  double H_m_ = 0;
  Obstacles of_a_, of_b_;
};

/** Compares the poses that rival with the best once more, by more voxels. */
void compareRivals(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                   const ComparisonParams& params, std::vector<RankedPose>& hypotheses);

/** All voxels may take the best pose elsewhere than the few voxels did by which it was compared.
 * Then the pose that they lead to is compared with the others: it is the first, whatever they are
 * worth. */
void compareWhatWasReached(const MapFeatures& a, const MapFeatures& b,
                           const VoxelAssociation& association, const ComparisonParams& params,
                           MatchResult& result);

/** Compares a match with a pose found elsewhere. If the maps agree so much better there that the
 * agreement of the match is less than \a as_good times it, inserts that pose as
 * result.hypotheses[1] and returns true. */
bool compareWithPoseElsewhere(const MapFeatures& a, const MapFeatures& b,
                              const Eigen::Isometry3d& elsewhere, double as_good,
                              const ComparisonParams& params, MatchResult& result);

}  // namespace mrpt::fusion
