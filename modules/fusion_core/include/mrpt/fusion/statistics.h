// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <octomap/OcTree.h>

#include <cstddef>

/** \file
 * How much a map knows, and how surely. */

namespace mrpt::fusion {

/** Figures of a map's voxels, each pruned leaf counted as the finest voxels it stands for. */
struct MapStatistics {
  size_t occupied = 0;               ///< finest voxels
  size_t free = 0;                   ///< finest voxels
  double mean_entropy_occupied = 0;  ///< mean of binaryEntropy() over occupied voxels, nats
  double mean_entropy_known = 0;     ///< over occupied and free voxels, nats
};
/** Counts all of a map's voxels. One traversal. */
MRPT_FUSION_API MapStatistics statisticsOf(const octomap::OcTree& map);

/** Shannon entropy of an occupancy probability, `-p ln p - (1-p) ln(1-p)`, in nats: the measure of
 * the paper's Table V. 0 at p = 0 and p = 1. */
MRPT_FUSION_API double binaryEntropy(double p);

}  // namespace mrpt::fusion
