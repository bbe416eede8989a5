// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/registration_params.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "fusion_core/features/features.h"
#include "fusion_core/registration/two_level.h"
#include "fusion_core/verdict/agreement.h"

/** \file
 * Comparison of poses: finds the best pose and its rivals. */

namespace mrpt::fusion {

/** Settings of a comparison of poses. */
struct ComparisonParams {
  RegistrationParams registration;  ///< Settings of the refinement
  RankingParams ranking;            ///< Numbers of voxels and poses, precision
  PoseTolerance tolerance;          ///< Largest distance of poses at the same place
  BorderParams border;              ///< Weight of some conflicts
  double spacing;                   ///< Width of the cubes that give at most one voxel each, m
};

/** Returns registration parameters of lower precision, for the comparison of poses. */
RegistrationParams roughly(RegistrationParams registration, const RankingParams& ranking);

/** Returns the distance of two poses T and U of map B: the larger of the distances of position and
 * rotation, each divided by its tolerance.
 * \param[in] T,U The poses.
 * \param[in] middle Mean of B's voxels, m, B's frame.
 * \param[in] tolerance The tolerance. */
double distanceBetween(const Eigen::Isometry3d& T, const Eigen::Isometry3d& U,
                       const Eigen::Vector3d& middle, const PoseTolerance& tolerance);

/** True if two poses of map B differ by at most the tolerance. Parameters: as distanceBetween(). */
bool isSamePlace(const Eigen::Isometry3d& T, const Eigen::Isometry3d& U,
                 const Eigen::Vector3d& middle, const PoseTolerance& tolerance);

/** Comparison of poses by some voxels of each map: refines the poses with these voxels, and
 * computes the agreement of the maps. It refers to the maps and the association, which must outlive
 * it. Several threads may use it. */
class PoseComparison {
 public:
  /** \param[in] a,b Features of the maps A and B.
   * \param[in] association Association of A's matched voxels.
   * \param[in] params Settings.
   * \param[in] voxels Number of voxels of each map. */
  PoseComparison(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                 const ComparisonParams& params, size_t voxels);
  /** \overload
   * Uses the given voxels \a few_b of B, see voxelsOf(). */
  PoseComparison(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                 const ComparisonParams& params, size_t voxels, SurfaceVoxels few_b);

  /** Returns the voxels of a map for a comparison by \a voxels voxels. */
  static SurfaceVoxels voxelsOf(const MapFeatures& map, const ComparisonParams& params,
                                size_t voxels);

  /** Refines the starts and returns the resulting poses, best first. Of poses at the same place it
   * returns only the best. */
  std::vector<RankedPose> ranked(const std::vector<Eigen::Isometry3d>& starts) const;
  /** Returns the covariance of a pose from these voxels, see MatchResult::covariance. */
  Matrix6d covarianceAt(const Eigen::Isometry3d& T_a_b) const;
  /** Returns the agreement of the maps at a pose, see agreement(). */
  double agreementAt(const Eigen::Isometry3d& T_a_b) const;
  /** Returns the refined pose with its agreement. */
  RankedPose refined(const Eigen::Isometry3d& start) const;
  /** Returns some obstacles of A and of B, in the frames of their maps. */
  const Obstacles& obstaclesOfA() const { return of_a_; }
  const Obstacles& obstaclesOfB() const { return of_b_; }

 private:
  VoxelLevel level() const;

  const MapFeatures &a_, &b_;
  const VoxelAssociation& association_;
  const ComparisonParams params_;
  const RegistrationParams rough_;
  SurfaceVoxels few_b_;
  double H_m_ = 0;
  Obstacles of_a_, of_b_;
};

/** Compares the best pose and its rivals again, with more voxels. */
void compareRivals(const MapFeatures& a, const MapFeatures& b, const VoxelAssociation& association,
                   const ComparisonParams& params, std::vector<RankedPose>& hypotheses);

/** Updates the hypotheses if the registration with all voxels has moved the pose by more than
 * RankingParams::moved_share of the tolerance. The final pose is then compared with the hypotheses,
 * and becomes the first hypothesis for any agreement. */
void compareWhatWasReached(const MapFeatures& a, const MapFeatures& b,
                           const VoxelAssociation& association, const ComparisonParams& params,
                           MatchResult& result);

/** Makes a hypothesis the first. The others follow it, best agreement first. */
void makeFirst(size_t i, std::vector<RankedPose>& hypotheses);

/** Adds a rival to the hypotheses of a match, unless they hold its place with a larger agreement.
 * \param[in] b Features of map B.
 * \param[in] rival The rival; its agreement is not used.
 * \param[in] ratio Agreement of the rival over the agreement of the match.
 * \param[in] tolerance Largest distance of poses at the same place.
 * \param[in,out] result The match; it has hypotheses. */
void addRival(const MapFeatures& b, RankedPose rival, double ratio, const PoseTolerance& tolerance,
              MatchResult& result);

/** A pose that agrees clearly better than a match. */
struct BetterPose {
  RankedPose pose;  ///< The pose after refinement
  double of_match;  ///< Agreement of the match, by the same voxels
};

/** Compares a match with a pose from another search. Returns that pose if the agreement of the
 * match is at most \a as_good times the agreement of that pose, and both are different places. */
std::optional<BetterPose> betterPoseElsewhere(const MapFeatures& a, const MapFeatures& b,
                                              const Eigen::Isometry3d& T_a_b,
                                              const Eigen::Isometry3d& elsewhere, double as_good,
                                              const ComparisonParams& params);

/** Inserts a better pose as result.hypotheses[1]. */
void insertBetter(const BetterPose& better, MatchResult& result);

}  // namespace mrpt::fusion
