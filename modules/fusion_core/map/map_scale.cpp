// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Computes the scale of a map from its voxel size and its extent. */
#include "fusion_core/map/map_scale.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace mrpt::fusion {
namespace {

float medianOf(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/** Returns the size of the scene, m, see scaleOf(). */
double sizeOf(const OccupiedVoxels& voxels) {
  double size = 0;
  std::vector<float> along(voxels.size());
  for (unsigned axis = 0; axis < 3; axis++) {
    std::transform(voxels.centre.begin(), voxels.centre.end(), along.begin(),
                   [=](const Eigen::Vector3f& p) { return p[axis]; });
    const float middle = medianOf(along);
    for (float& x : along) x = std::abs(x - middle);
    size = std::max(size, 4.0 * medianOf(along));
  }
  return size;
}

}  // namespace

double scaleOf(const OccupiedVoxels& voxels, const ScaleParams& params) {
  if (params.fixed > 0) return params.fixed;
  const double resolution = voxels.resolution;
  if (voxels.size() == 0 || !(resolution > 0)) return 1;
  if (resolution > params.coarse_voxel) return resolution / params.coarse_voxel;
  if (resolution >= params.fine_voxel) return 1;
  const double of_scene = std::min(sizeOf(voxels) / params.small_scene, 1.0);
  return std::max(resolution / params.fine_voxel, of_scene);
}

}  // namespace mrpt::fusion
