// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/search_params.h>

#include <vector>

#include "fusion_core/search/pose_search.h"

/** \file
 * The search for maps that have no common vertical. */

namespace mrpt::fusion {

/** Runs searchAround() for maps that have no common vertical, without bounds (everywhere()).
 *
 * The dominant direction of A is the direction that most of its surfaces face: usually floors and
 * ceilings, or walls. Each of AllRotationsParams::directions directions of B is turned onto it,
 * with both signs. Each search covers all rotations about this direction and all translations. The
 * search finds nothing if surfaces face all directions equally, as in a cave. Cost: 2 searches for
 * each direction of B. If A's dominant direction is not its z axis, A's octree is resampled.
 * \return The best poses of all these searches. */
std::vector<Hypothesis> searchAllRotations(const MapVoxels& a, const Surfaces& surfaces_a,
                                           const SurfaceVoxels& b, const SearchParams& params);

}  // namespace mrpt::fusion
