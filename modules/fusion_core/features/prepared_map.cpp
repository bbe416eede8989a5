// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Implements the data that copies of a prepared map share. */
#include <mrpt/core/exceptions.h>
#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/prepared_map.h>

#include <cstring>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "fusion_core/features/features.h"
#include "fusion_core/features/parameters.h"
#include "fusion_core/map/map_scale.h"
#include "fusion_octree/files.h"
#include "fusion_octree/resolution.h"

namespace mrpt::fusion {
namespace {

/** FNV-1a, 64 bits. */
class ContentHash {
 public:
  void add(std::string_view bytes) {
    for (const char c : bytes) {
      value_ ^= static_cast<unsigned char>(c);
      value_ *= 0x100000001b3ULL;
    }
  }
  void add(double value) {
    char bytes[sizeof(value)];
    std::memcpy(bytes, &value, sizeof(value));
    add(std::string_view(bytes, sizeof(bytes)));
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0xcbf29ce484222325ULL;
};

}  // namespace

struct PreparedMap::Prepared {
  Prepared(std::shared_ptr<const octomap::OcTree> map, const FeatureParams& p,
           std::optional<EdgeVoxels> edges)
      : octree(std::move(map)), params(p), edges_alone(std::move(edges)) {
    checkResolution(octree->getResolution());
    if (edges_alone) {
      features = featuresOfEdges(octree, *octree, *edges_alone);
      features.scale = scaleOf(features.voxels, params.scale);
    } else {
      features = computeFeatures(octree, params);
    }
  }

  /** Computes the hash at the first call: few users need it. */
  uint64_t hash() const {
    std::call_once(hashed, [this] {
      ContentHash h;
      h.add(octree->getResolution());
      serializeNodes(*octree, [&h](std::string_view piece) { h.add(piece); });
      FeatureParams copy(params);
      for (const Parameter& p : parametersOf(copy)) h.add(p.value());
      content_hash = h.value();
    });
    return content_hash;
  }

  const MapFeatures& byEdges() const {
    if (edges_alone) return features;
    std::call_once(edges_extracted, [this] {
      const EdgeVoxels all = extractEdges(features.voxels, scaledBy(params, features.scale).edges);
      features_by_edges = featuresOfEdges(octree, occupancyTree(all), all);
      features_by_edges.scale = features.scale;
    });
    return features_by_edges;
  }

  const std::shared_ptr<const octomap::OcTree> octree;
  const FeatureParams params;
  const std::optional<EdgeVoxels> edges_alone;
  MapFeatures features;
  mutable std::once_flag hashed, edges_extracted;
  mutable uint64_t content_hash = 0;
  mutable MapFeatures features_by_edges;
};

PreparedMap::PreparedMap(std::shared_ptr<const octomap::OcTree> octree,
                         const FeatureParams& params) {
  if (!octree) throw std::invalid_argument("there is no map to prepare");
  prepared_ = std::make_shared<const Prepared>(std::move(octree), params, std::nullopt);
}

PreparedMap::PreparedMap(const octomap::OcTree& octree, const FeatureParams& params)
    : PreparedMap(std::make_shared<const octomap::OcTree>(octree), params) {}

PreparedMap::PreparedMap(const EdgeVoxels& edges, const FeatureParams& params)
    : prepared_(std::make_shared<const Prepared>(
          std::make_shared<const octomap::OcTree>(occupancyTree(edges)), params, edges)) {}

bool PreparedMap::isEdgesAlone() const { return prepared_->edges_alone.has_value(); }

const std::shared_ptr<const octomap::OcTree>& PreparedMap::octree() const {
  return prepared_->octree;
}

const octomap::OcTree& PreparedMap::wholeMap() const {
  ASSERTMSG_(!isEdgesAlone(), "the map consists of edges only; a 3-D occupancy map is needed");
  return *prepared_->octree;
}

const EdgeVoxels& PreparedMap::edges() const { return prepared_->features.edges; }
size_t PreparedMap::occupiedVoxels() const { return prepared_->features.voxels.size(); }
double PreparedMap::scale() const { return prepared_->features.scale; }
uint64_t PreparedMap::contentHash() const { return prepared_->hash(); }

const Sources& PreparedMap::sources() const {
  static const Sources none;
  return sources_ ? *sources_ : none;
}

PreparedMap PreparedMap::withSources(Sources sources) const {
  PreparedMap copy(*this);
  copy.sources_ = std::make_shared<const Sources>(std::move(sources));
  return copy;
}

const MapFeatures& PreparedMap::features() const { return prepared_->features; }
const MapFeatures& PreparedMap::featuresByEdges() const { return prepared_->byEdges(); }

}  // namespace mrpt::fusion
