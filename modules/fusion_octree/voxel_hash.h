// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstdint>

/** \file
 * A hash of the voxels of a map. */

namespace mrpt::fusion {

/** Returns a hash of the resolution and of the log-odds of all voxels of an octree.
 *
 * Octrees with the same voxels have the same hash, pruned or not. Inner nodes and the sensor model
 * do not count. The hash is the same on all machines and in all versions. It is not cryptographic.
 * Cost: one traversal. */
uint64_t voxelHash(const octomap::OcTree& map);

}  // namespace mrpt::fusion
