// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/export.h>
#include <octomap/OcTree.h>

#include <cstddef>
#include <cstdint>
#include <memory>

/** \file
 * A map made ready for matching: prepared once, matched many times. */

namespace mrpt::fusion {

/** Settings of the features that matching needs of a map. */
struct FeatureParams {
  EdgeParams edges;  ///< Algorithm 1
  /** Matching works on one voxel in each cube of the octree that is at least this wide, m: the
   * voxel that is most likely occupied, with the weight of all voxels of the cube. 0: on all
   * voxels, as published. */
  double voxel_spacing = 0.2;
  /** Edges are searched for where the surface bends most in each cube of the octree that is at
   * least this wide, m. 0: everywhere, as published; a match without a search needs that. */
  double edge_spacing = 0.4;
};

struct MapFeatures;

/** An occupancy map, or structural edges alone, with all that matching needs of it.
 *
 * An immutable value: copies share octree and features, and may be used by several threads at once.
 * It owns what it refers to, so a program can keep it, cache it by contentHash(), or match it with
 * any number of other maps. */
class MRPT_FUSION_API PreparedMap {
 public:
  /** Prepares a whole map. Deterministic, whatever the number of threads.
   * \param[in] octree The map; shared, must not change afterwards. \param[in] params See each
   * field. \exception std::invalid_argument If the map is null. \exception std::length_error If it
   * has more than kMaxVoxels occupied voxels. Cost: O(voxels * neighbours), see extractEdges(). */
  explicit PreparedMap(std::shared_ptr<const octomap::OcTree> octree,
                       const FeatureParams& params = {});
  /** \overload
   * Copies the map. */
  explicit PreparedMap(const octomap::OcTree& octree, const FeatureParams& params = {});
  /** Prepares structural edges of which no map is known. They tell where maps meet, and are never
   * accepted as a match to merge by. \exception std::exception See occupancyTree(). */
  explicit PreparedMap(const EdgeVoxels& edges, const FeatureParams& params = {});

  /** True if only edges are known. */
  bool isEdgesAlone() const;
  /** The map, never null. If only edges are known: the edges as occupied voxels. */
  const std::shared_ptr<const octomap::OcTree>& octree() const;
  /** The map. \exception std::exception If only edges are known: they cannot be judged or merged.
   */
  const octomap::OcTree& wholeMap() const;
  /** Edge voxels that the edge level matches, in the map's frame. */
  const EdgeVoxels& edges() const;
  /** Number of occupied voxels, at the finest resolution. */
  size_t occupiedVoxels() const;
  /** Hash of the octree's structure, log-odds and resolution, and of the parameters: equal for
   * equal maps that were prepared alike, on any machine of the same byte order. Not cryptographic.
   */
  uint64_t contentHash() const;

  /** The features, for the stages of matching. \return Valid as long as this map or a copy. */
  const MapFeatures& features() const;
  /** The features of a comparison by edges alone; computed at the first call, by one thread. */
  const MapFeatures& featuresByEdges() const;

 private:
  struct Prepared;
  std::shared_ptr<const Prepared> prepared_;
};

}  // namespace mrpt::fusion
