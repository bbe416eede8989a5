// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Prepares maps of MRPT, and fuses two maps. */

#include <mrpt/fusion/fusion.h>
#include <mrpt/fusion/many_maps.h>
#include <mrpt/maps/CEdgeVoxelMap.h>

#include <stdexcept>
#include <utility>

#include "mrpt_fusion/borrowed.h"

using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;

namespace mrpt::fusion {
namespace {

[[noreturn]] void throwNoMap(const CMetricMap& map) {
  THROW_EXCEPTION(std::string("a ") + map.GetRuntimeClass()->className +
                  " is not, and holds no, 3-D occupancy map");
}

}  // namespace

PreparedMap prepareBorrowed(const CMetricMap& map, const FeatureParams& params) {
  if (const auto* edges = dynamic_cast<const CEdgeVoxelMap*>(&map))
    return PreparedMap(edges->edges(), params);
  const auto octomap = asProbOctoMap(map);
  if (!octomap) throwNoMap(map);
  return PreparedMap(std::shared_ptr<const octomap::OcTree>(octomap, &octomap->octree()), params)
      .withSources(octomap->sources());
}

PreparedMap prepare(const CMetricMap& map, const FeatureParams& params) {
  if (const auto* edges = dynamic_cast<const CEdgeVoxelMap*>(&map))
    return PreparedMap(edges->edges(), params);
  const auto octomap = asProbOctoMap(map);
  if (!octomap) throwNoMap(map);
  return PreparedMap(octomap->octree(), params).withSources(octomap->sources());
}

PreparedMap prepare(const std::shared_ptr<const CMetricMap>& map, const FeatureParams& params) {
  ASSERTMSG_(map, "there is no map to prepare");
  if (dynamic_cast<const CEdgeVoxelMap*>(map.get())) return prepare(*map, params);
  const auto octomap = asProbOctoMap(map);
  if (!octomap) throwNoMap(*map);
  return PreparedMap(std::shared_ptr<const octomap::OcTree>(octomap, &octomap->octree()), params)
      .withSources(octomap->sources());
}

Fused::Fused(Alignment alignment, std::shared_ptr<const CProbOctoMap> map)
    : alignment_(std::move(alignment)), map_(std::move(map)) {}

std::string Fused::why() const {
  const Evaluation& e = alignment_.evaluation;
  std::string all;
  for (const auto& reason : e.accepted ? e.reasons : e.against())
    all += (all.empty() ? "" : "; ") + reason;
  return all;
}

const CProbOctoMap& Fused::map() const {
  if (!map_) throw std::logic_error("the match is rejected, nothing was merged: " + why());
  return *map_;
}

Fused fuse(const PreparedMap& a, const PreparedMap& b, const Prior& prior, const Options& options) {
  Alignment found = align(a, b, prior, options);
  if (!found.evaluation.accepted) return {std::move(found), nullptr};
  auto merged = mergeSources({a.wholeMap(), a.sources()}, {b.wholeMap(), b.sources()},
                             found.match.T_a_b, options.merge);
  auto map = std::make_shared<CProbOctoMap>(std::move(merged.map));
  map->setSources(std::move(merged.sources));
  return {std::move(found), std::move(map)};
}

Fused fuse(const CMetricMap& a, const CMetricMap& b, const Prior& prior, const Options& options) {
  return fuse(prepareBorrowed(a, options.features), prepareBorrowed(b, options.features), prior,
              options);
}

}  // namespace mrpt::fusion
