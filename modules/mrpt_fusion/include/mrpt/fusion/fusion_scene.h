// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/compat.h>
#include <mrpt/fusion/fusion_view.h>

/** \file
 * What a fusion did, to look at. */

namespace mrpt::fusion {

/** A scene of named objects, each to be found by getByName() and switched on and off:
 * "map A" (orange), "map B" (blue, moved to its pose), "edges A" and "edges B", the matched pairs
 * as lines, "inliers" (black) and "outliers" (red) as in the paper's Fig. 9, and "fused map" with
 * its occupancy probabilities from dark to bright, as in Fig. 4. The fused map is drawn beside the
 * others, for it would hide them: its object's pose shifts it, its voxels are in A's frame.
 * O(voxels). */
mrpt::fusion::Scene::Ptr drawFusion(const FusionView& view);

}  // namespace mrpt::fusion
