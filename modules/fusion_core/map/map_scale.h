// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/voxels.h>

/** \file
 * The scale of a map: the factor of all lengths in the options. */

namespace mrpt::fusion {

/** Returns the factor by which the lengths of the options are multiplied for a map. The default
 * lengths fit buildings at voxels of 5 to 20 cm; the factor is 1 there.
 * - Larger voxels: the factor is the voxel size over ScaleParams::coarse_voxel.
 * - Smaller voxels: the voxel size over ScaleParams::fine_voxel, but at least the size of the scene
 *   over ScaleParams::small_scene, at most 1. A building at fine voxels keeps its lengths; a desk
 *   gets shorter lengths.
 *
 * The size of the scene is 4 times the median distance from the median, along the axis where this
 * is largest: the length of an evenly filled box. Stray returns do not change it.
 * Cost: O(1), for smaller voxels O(n). */
double scaleOf(const OccupiedVoxels& voxels, const ScaleParams& params);

}  // namespace mrpt::fusion
