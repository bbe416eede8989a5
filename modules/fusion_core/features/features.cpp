// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Extracts the voxels, surfaces and edges of a map. */
#include "fusion_core/features/features.h"

#include <atomic>
#include <utility>

#include "fusion_core/features/edges.h"
#include "fusion_core/features/parameters.h"
#include "fusion_core/features/thinning.h"
#include "fusion_core/map/map_scale.h"

namespace mrpt::fusion {

namespace {
std::atomic<size_t> extractions{0};
}  // namespace

size_t featureExtractions() { return extractions; }

MapFeatures computeFeatures(std::shared_ptr<const octomap::OcTree> map,
                            const FeatureParams& unscaled) {
  extractions++;
  MapFeatures f{MapVoxels(std::move(map)), {}, {}};
  f.scale = scaleOf(f.voxels, unscaled.scale);
  const FeatureParams params = scaledBy(unscaled, f.scale);
  const auto kept = thinOut(f.voxels, params.voxel_spacing);
  f.matched.voxels = select(f.voxels, kept.index);
  f.matched.surfaces = computeSurfaces(f.matched.voxels, f.occupied, params.edges);
  f.matched.surfaces.weight = kept.weight;
  f.edges = extractEdges(f.voxels, f.occupied, f.matched, edgeCandidates(f.matched, params),
                         params.edges);
  return f;
}

MapFeatures featuresOfEdges(std::shared_ptr<const octomap::OcTree> map,
                            const octomap::OcTree& edge_tree, const EdgeVoxels& edges) {
  MapFeatures f{MapVoxels(std::move(map)), {extractOccupiedVoxels(edge_tree), {}}, edges};
  const size_t n = f.matched.voxels.size();
  f.matched.surfaces.normal.assign(n, Eigen::Vector3f::Zero());
  f.matched.surfaces.point = f.matched.voxels.centre;
  f.matched.surfaces.variation.assign(n, 0);
  f.matched.surfaces.weight.assign(n, 1);
  return f;
}

std::vector<uint32_t> edgeCandidates(const SurfaceVoxels& matched, const FeatureParams& params) {
  const std::vector<float>& variation = matched.surfaces.variation;
  return thinOut(matched.voxels, params.edge_spacing,
                 [&](uint32_t i, uint32_t j) { return variation[i] > variation[j]; })
      .index;
}

bool isEmpty(const MapFeatures& a, const MapFeatures& b) {
  return a.voxels.size() == 0 || b.voxels.size() == 0;
}

Eigen::AlignedBox3d boxOf(const MapFeatures& map) {
  Eigen::AlignedBox3d box;
  for (const auto& p : map.matched.voxels.centre) box.extend(p.cast<double>());
  return box;
}

}  // namespace mrpt::fusion
