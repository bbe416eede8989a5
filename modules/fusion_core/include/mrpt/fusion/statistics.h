// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <octomap/OcTree.h>

#include <cstddef>

/** \file
 * Counts and entropies of the voxels of a map. */

namespace mrpt::fusion {

/** Figures of a map's voxels. A pruned leaf counts as all finest voxels in it. */
struct MapStatistics {
  size_t occupied = 0;               ///< Number of occupied finest voxels
  size_t free = 0;                   ///< Number of free finest voxels
  double mean_entropy_occupied = 0;  ///< Mean binaryEntropy() of occupied voxels, nats
  double mean_entropy_known = 0;     ///< Mean over occupied and free voxels, nats
};
/** Counts the voxels of a map. Cost: one traversal. */
MRPT_FUSION_API MapStatistics statisticsOf(const octomap::OcTree& map);

/** Returns the Shannon entropy of an occupancy probability, `-p ln p - (1-p) ln(1-p)`, nats: the
 * measure of the paper's Table V. It is 0 at p = 0 and p = 1. */
MRPT_FUSION_API double binaryEntropy(double p);

}  // namespace mrpt::fusion
