// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/compat.h>
#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/export.h>
#include <mrpt/poses/CPose3D.h>
#include <octomap/OcTree.h>

#include "fusion_core/registration/association.h"

/** \file
 * What a fusion did, to look at. */

namespace mrpt::fusion {

/** What of a fusion to draw; all poses are of map B in A's frame. Nothing is owned. */
struct FusionView {
  const octomap::OcTree& a;                ///< the model map
  const octomap::OcTree& b;                ///< the scene map
  mrpt::poses::CPose3D pose;               ///< of B
  const Pairs& pairs;                      ///< of the occupied voxels, at that pose
  const EdgeVoxels& edges_a;               ///< in A's frame
  const EdgeVoxels& edges_b;               ///< in B's frame
  double inlier_mahalanobis;               ///< see EvaluationParams
  const octomap::OcTree* fused = nullptr;  ///< if there is one
};

/** A scene of named objects, each to be found by getByName() and switched on and off:
 * "map A" (orange), "map B" (blue, moved to its pose), "edges A" and "edges B", the matched pairs
 * as lines, "inliers" (black) and "outliers" (red) as in the paper's Fig. 9, and "fused map" with
 * its occupancy probabilities from dark to bright, as in Fig. 4. The fused map is drawn beside the
 * others, for it would hide them: its object's pose shifts it, its voxels are in A's frame.
 * O(voxels). */
MRPT_FUSION_API Scene::Ptr drawFusion(const FusionView& view);

}  // namespace mrpt::fusion
