// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/search_params.h>

#include <Eigen/Geometry>
#include <vector>

#include "fusion_core/search/pose_search.h"

/** \file
 * The search for maps whose verticals differ by some degrees. */

namespace mrpt::fusion {

/** Returns the direction that the ground of a map faces: ground, floors and ceilings. The voxels
 * whose surface faces up or down are cut into blocks of columns, and these into layers; the
 * direction has the median slope of all layers. It is the z axis if there is no layer. Unit vector.
 * Cost: O(n log n) for n voxels. */
Eigen::Vector3d upDirection(const SurfaceVoxels& map, const LevellingParams& params);

/** Runs searchAround() without bounds (everywhere()), for maps that are upright to within some
 * degrees.
 *
 * A tilt moves the far end of B up or down. If the up directions of the maps differ by more than
 * LevellingParams::max_cells cells at the far end, B is turned such that they agree, and searched
 * for a second time. The first search stays: the up directions of two parts of a hillside differ
 * as well. If no place of both searches stands out, B is also turned by such a difference in 6
 * directions, until a place stands out.
 * \param[in] a Map A.
 * \param[in] matched_a,matched_b Voxels of the maps with their surfaces, for the up directions.
 * \param[in] few_b,T_a_b,params As for searchAround().
 * \return The best poses of both searches if the second scores better, else those of the first. */
std::vector<Hypothesis> searchLevelled(const MapVoxels& a, const SurfaceVoxels& matched_a,
                                       const SurfaceVoxels& matched_b, const SurfaceVoxels& few_b,
                                       const Eigen::Isometry3d& T_a_b, const SearchParams& params);

}  // namespace mrpt::fusion
