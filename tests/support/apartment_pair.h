// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "fusion_core/features/features.h"
#include "fusion_octree/resampling.h"
#include "support/matching_tools.h"
#include "support/test_maps.h"

/** \file
 * A pair of overlapping maps with a known pose. */

namespace mrpt::fusion::test {

/** Computes features with all edges: tests run the edge level separately, too. */
inline MapFeatures allFeaturesOf(const octomap::OcTree& map) {
  FeatureParams params;
  params.edge_spacing = 0;
  return computeFeatures(borrowed(map), params);
}

/** Two maps of an apartment that overlap by 3.5 m. Each map has its own grid, and a frame inside
 * the apartment. Tests that do not check accuracy use a coarse voxel size, which takes 25 % of the
 * time. */
struct ApartmentPair {
  explicit ApartmentPair(double voxel_size) : resolution(voxel_size) {}

  const double resolution;
  const Eigen::Isometry3d T_a_w = poseOf(-1.7, -4.5, -0.53, 23, 1, -0.5);
  const Eigen::Isometry3d T_b_w = poseOf(-6, 4.3, -1.2, -64, -0.7, 1.3);
  const Eigen::Isometry3d truth = T_a_w * T_b_w.inverse();
  const std::unique_ptr<octomap::OcTree> map_a =
      mrpt::fusion::transformOcTree(*apartment({0, 0, 0}, {65, 69, 25}), T_a_w, resolution);
  const std::unique_ptr<octomap::OcTree> map_b =
      mrpt::fusion::transformOcTree(*apartment({30, 0, 0}, {99, 69, 25}), T_b_w, resolution);
  const MapFeatures a = allFeaturesOf(*map_a);
  const MapFeatures b = allFeaturesOf(*map_b);
};

}  // namespace mrpt::fusion::test
