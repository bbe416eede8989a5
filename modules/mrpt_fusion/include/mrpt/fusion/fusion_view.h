// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/poses/CPose3D.h>
#include <octomap/OcTree.h>

#include "fusion_core/registration/association.h"

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

}  // namespace mrpt::fusion
