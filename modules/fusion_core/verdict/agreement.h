// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_core/map/occupancy_query.h"

/** \file
 * The agreement of two maps at a pose, which ranks hypotheses. */

namespace mrpt::fusion {

/** Some obstacles of a map, for comparisons of poses. */
struct Obstacles {
  std::vector<Eigen::Vector3f> centre;  ///< Centres of the obstacles, m, map frame
  /** Unit normal of the obstacle's surface, towards the free space in front of it. Zero if there is
   * free space on both sides or on no side. */
  std::vector<Eigen::Vector3f> front;
};
/** Converts surface voxels to obstacles with the side from which the map has seen them. */
Obstacles obstaclesOf(const MapVoxels& map, const SurfaceVoxels& voxels,
                      const AgreementParams& params = {});

/** Compares an obstacle of another map with a map. Confirmed needs the same side, see agreement():
 * an obstacle seen from the other side is Unknown.
 * \param[in] map The map.
 * \param[in] obstacles Obstacles of the other map.
 * \param[in] i Index of the obstacle.
 * \param[in] before Distance of the free space in front of an obstacle, m.
 * \param[in] T Pose of the other map in the frame of the map. */
ObstacleCheck checkFromSameSide(const MapVoxels& map, const Obstacles& obstacles, size_t i,
                                double before, const Eigen::Isometry3d& T);

/** Returns the number of obstacles that the other map confirms from the same side, see
 * checkFromSameSide(). Both maps count. Cost: O(obstacles). */
size_t confirmedFromSameSide(const MapVoxels& a, const Obstacles& of_a, const MapVoxels& b,
                             const Obstacles& of_b, const Eigen::Isometry3d& T_a_b,
                             const AgreementParams& params = {});

/** Returns the weight of a conflict with a map at a point, m, map frame. */
double conflictWeight(const MapVoxels& map, const Eigen::Vector3d& p, const BorderParams& border);

/** Returns the agreement of two maps at a pose (not in the paper): the number of obstacles that the
 * other map confirms, times exp(-r / tolerance). r is the conflict ratio: obstacles in the other
 * map's free space over obstacles that the other map confirms or contradicts. Some conflicts count
 * less, see BorderParams.
 *
 * The right pose has few conflicts (0 to 7 % on all our maps). A wrong pose may have a larger
 * overlap. An obstacle has weight 1 if both maps see it from the same side, otherwise
 * AgreementParams::other_side: a floor on a ceiling, and rooms back to back, have no conflicts. */
double agreement(const MapVoxels& a, const Obstacles& of_a, const MapVoxels& b,
                 const Obstacles& of_b, const Eigen::Isometry3d& T_a_b,
                 const AgreementParams& params = {}, const BorderParams& border = {});

}  // namespace mrpt::fusion
