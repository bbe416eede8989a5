// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/compat.h>
#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/export.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/poses/CPose3D.h>
#include <octomap/OcTree.h>

/** \file
 * The result of a fusion as a 3-D scene. */

namespace mrpt::fusion {

/** The parts of a fusion that are drawn. Nothing is owned. */
struct FusionView {
  const octomap::OcTree& a;                ///< Map A
  const octomap::OcTree& b;                ///< Map B
  mrpt::poses::CPose3D pose;               ///< Pose of B in A's frame
  const Pairs& pairs;                      ///< Pairs of occupied voxels at that pose
  const EdgeVoxels& edges_a;               ///< Edges of A, in A's frame
  const EdgeVoxels& edges_b;               ///< Edges of B, in B's frame
  double inlier_mahalanobis;               ///< Mahalanobis distance below which a pair is an inlier
  const octomap::OcTree* fused = nullptr;  ///< Fused map; null: none
};

/** Draws a scene of named objects. getByName() finds each object. The objects are "map A" (orange),
 * "map B" (blue, at its pose), "edges A", "edges B", the pairs as lines, "inliers" (black) and
 * "outliers" (red), as in Fig. 9 of the paper, and "fused map" with probabilities from dark to
 * bright, as in Fig.
 * 4. The fused map would hide the other maps, so the pose of its object moves it to their side. Its
 * voxels are in A's frame. O(voxels). */
MRPT_FUSION_API Scene::Ptr drawFusion(const FusionView& view);

}  // namespace mrpt::fusion
