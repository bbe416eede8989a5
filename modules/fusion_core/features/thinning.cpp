// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Chooses voxels that represent the voxels around them. */
#include "fusion_core/features/thinning.h"

#include "fusion_core/map/map_voxels.h"

namespace mrpt::fusion {
namespace {

Surfaces select(const Surfaces& surfaces, const std::vector<uint32_t>& indices) {
  Surfaces some;
  for (const uint32_t i : indices) {
    some.normal.push_back(surfaces.normal[i]);
    some.point.push_back(surfaces.point[i]);
    some.variation.push_back(surfaces.variation[i]);
    some.weight.push_back(surfaces.weight[i]);
  }
  return some;
}

}  // namespace

OccupiedVoxels select(const OccupiedVoxels& voxels, const std::vector<uint32_t>& indices) {
  OccupiedVoxels some;
  some.resolution = voxels.resolution;
  some.centre.reserve(indices.size());
  some.probability.reserve(indices.size());
  some.key.reserve(indices.size());
  for (const uint32_t i : indices) {
    some.centre.push_back(voxels.centre[i]);
    some.probability.push_back(voxels.probability[i]);
    some.key.push_back(voxels.key[i]);
  }
  return some;
}

Thinned thinOut(const OccupiedVoxels& voxels, double spacing) {
  return thinOut(voxels, spacing, [&](uint32_t i, uint32_t j) {
    return voxels.probability[i] > voxels.probability[j];
  });
}

SurfaceVoxels fewOf(const SurfaceVoxels& all, double spacing, size_t enough) {
  const OccupiedVoxels& voxels = all.voxels;
  const Surfaces& surfaces = all.surfaces;
  const auto kept = thinOut(voxels, spacing, [&](uint32_t i, uint32_t j) {
    const bool flat_i = !surfaces.normal[i].isZero(), flat_j = !surfaces.normal[j].isZero();
    return flat_i != flat_j ? flat_i : voxels.probability[i] > voxels.probability[j];
  });
  std::vector<uint32_t> few;
  const size_t stride = strideFor(kept.index.size(), enough);
  for (size_t k = 0; k < kept.index.size(); k += stride) few.push_back(kept.index[k]);
  return {select(voxels, few), select(surfaces, few)};
}

}  // namespace mrpt::fusion
