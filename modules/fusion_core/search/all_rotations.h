// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/search_params.h>

#include <vector>

#include "fusion_core/search/pose_search.h"

/** \file
 * The search for maps that have no common vertical. */

namespace mrpt::fusion {

/** searchAround() for maps that have no common vertical, from everywhere(). What faces A's dominant
 * direction (mostly its floors and ceilings, or walls) faces one of B's: each of B's four, with
 * either sign, is turned onto A's, and all turns about it and all translations are searched. So it
 * finds nothing where surfaces face everywhere alike, as in a cave.
 * \return The best poses of all these searches. Cost: eight searches, and if A's dominant direction
 * is not its z axis, an octree that is turned so that it is. */
std::vector<Hypothesis> searchAllRotations(const MapVoxels& a, const Surfaces& surfaces_a,
                                           const SurfaceVoxels& b, const SearchParams& params);

}  // namespace mrpt::fusion
