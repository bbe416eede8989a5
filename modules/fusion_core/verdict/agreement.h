// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>

#include <Eigen/Geometry>
#include <vector>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/map/map_voxels.h"

/** \file
 * How well two maps agree at a pose: what hypotheses are ranked by. */

namespace mrpt::fusion {

/** Some of a map's obstacles, to compare poses with. */
struct Obstacles {
  std::vector<Eigen::Vector3f> centre;  ///< m, map frame
  /** Unit normal of the obstacle's surface towards the free space before it; zero where the map has
   * seen it from both sides, or knows no free space there. */
  std::vector<Eigen::Vector3f> front;
};
/** The obstacles that a map's surface voxels are, with the side from which it has seen them. */
Obstacles obstaclesOf(const MapVoxels& map, const SurfaceVoxels& voxels,
                      const AgreementParams& params = {});

/** How well two maps agree at a pose, by some obstacles of each (not in the paper): the number of
 * obstacles that the other map confirms, times exp(-r / tolerance), where r is the share of
 * obstacles in the other map's free space, of all obstacles that it knows the place of. The right
 * pose has few conflicts (0 to 7 % on all our maps), while a wrong pose may have the larger
 * overlap. An obstacle counts in full if both maps see it from the same side, else in part: a floor
 * on a ceiling, or two rooms back to back, contradict nothing. */
double agreement(const MapVoxels& a, const Obstacles& of_a, const MapVoxels& b,
                 const Obstacles& of_b, const Eigen::Isometry3d& T_a_b,
                 const AgreementParams& params = {});

}  // namespace mrpt::fusion
