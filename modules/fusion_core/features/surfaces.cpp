// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Computes normals, points and variations of surfaces by principal component analysis. */
#include "fusion_core/features/surfaces.h"

#include <optional>

#include "fusion_base/parallel.h"
#include "fusion_core/features/least_axis.h"
#include "fusion_core/features/neighbourhoods.h"
#include "fusion_core/features/surface_moments.h"

namespace mrpt::fusion {
namespace {

/** Returns lambda_3 / (lambda_1 + lambda_2 + lambda_3), with lambda_3 the least eigenvalue, or
 * nothing without a plane. */
std::optional<double> surfaceVariation(const LeastAxis& across, const EdgeParams& params) {
  const double variation = across.value() / across.trace();
  if (!across.othersExceed(1e-6) || variation > params.max_surface_variation) return std::nullopt;
  return variation;
}

}  // namespace

Plane surfaceAround(const VoxelBlocks& occupied, const VoxelBlocks::Ball& ball,
                    const octomap::OcTreeKey& key, const EdgeParams& params) {
  const Moments moments = momentsAround(occupied, ball, key);
  const LeastAxis across(moments.covariance());
  const auto variation = surfaceVariation(across, params);
  if (!variation) return {};
  const Eigen::Vector3d normal = across.direction();
  return {normal.cast<float>(), static_cast<float>(*variation),
          static_cast<float>(normal.dot(moments.mean()))};
}

Surfaces computeSurfaces(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                         const EdgeParams& params) {
  const VoxelBlocks::Ball ball = normalBall(params, voxels.resolution);
  Surfaces surfaces;
  surfaces.normal.assign(voxels.size(), Eigen::Vector3f::Zero());
  surfaces.variation.assign(voxels.size(), 0);
  surfaces.weight.assign(voxels.size(), 1);
  surfaces.point = voxels.centre;
  forEachIndex(voxels.size(), kGrain, [&](size_t i) {
    const Plane plane = surfaceAround(occupied, ball, voxels.key[i], params);
    const auto height = static_cast<float>(voxels.resolution) * plane.height;
    surfaces.normal[i] = plane.normal;
    surfaces.point[i] += height * plane.normal;
    surfaces.variation[i] = plane.variation;
  });
  return surfaces;
}

Surfaces computeSurfaces(const OccupiedVoxels& voxels, const EdgeParams& params) {
  return computeSurfaces(voxels, VoxelBlocks(voxels.key), params);
}

}  // namespace mrpt::fusion
