// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/export.h>
#include <mrpt/fusion/sources.h>
#include <mrpt/fusion/voxels.h>
#include <octomap/OcTree.h>

#include <cstddef>
#include <cstdint>
#include <memory>

/** \file
 * A map with its features: prepared once, matched many times. */

namespace mrpt::fusion {

/** Settings of the features of a map. */
struct FeatureParams {
  ScaleParams scale;  ///< Scale of the map
  EdgeParams edges;   ///< Settings of Algorithm 1
  /** Least width of the cubes of the thinning, m. Matching uses one voxel of each cube of the
   * octree: the voxel with the highest probability, with the weight of all voxels of the cube.
   * 0: all voxels, as published. */
  double voxel_spacing = 0.2;
  /** Least width of the cubes of the edge extraction, m. Each cube of the octree has one candidate,
   * where the surface bends most. 0: all voxels are candidates, as published. A match without a
   * search needs 0. */
  double edge_spacing = 0.4;
};

struct MapFeatures;

/** An occupancy map, or only structural edges, with its features.
 *
 * An immutable value: copies share octree and features. Several threads may use it at once. It owns
 * its data, so a program can keep it, cache it by contentHash(), or match it with any number of
 * other maps. */
class MRPT_FUSION_API PreparedMap {
 public:
  /** Prepares a whole map. The result does not depend on the number of threads.
   * Cost: O(voxels * neighbours), see extractEdges().
   * \param[in] octree The map. It is shared and must not change afterwards.
   * \param[in] params Settings of the features.
   * \exception std::invalid_argument If the map is null.
   * \exception std::runtime_error If the voxel size is not in [1e-4, 1e6] m.
   * \exception std::length_error If the map has more than kMaxVoxels occupied voxels. */
  explicit PreparedMap(std::shared_ptr<const octomap::OcTree> octree,
                       const FeatureParams& params = {});
  /** \overload
   * Copies the map. */
  explicit PreparedMap(const octomap::OcTree& octree, const FeatureParams& params = {});
  /** Prepares structural edges without an occupancy map. Their match shows where maps meet. It is
   * never accepted.
   * \exception std::exception See occupancyTree(). */
  explicit PreparedMap(const EdgeVoxels& edges, const FeatureParams& params = {});

  /** True if the map has only edges. */
  bool isEdgesAlone() const;
  /** Returns the octree, never null. If the map has only edges, they are its occupied voxels. */
  const std::shared_ptr<const octomap::OcTree>& octree() const;
  /** Returns the octree.
   * \exception std::exception If the map has only edges: edges cannot be judged or merged. */
  const octomap::OcTree& wholeMap() const;
  /** Returns the edge voxels of the edge level, in the map's frame. */
  const EdgeVoxels& edges() const;
  /** Returns the number of occupied voxels at the finest resolution. */
  size_t occupiedVoxels() const;
  /** Returns the scale of the map, see ScaleParams. */
  double scale() const;
  /** Returns a hash of the octree's structure, log-odds and resolution, and of the parameters.
   * Equal maps with equal parameters have equal hashes on all machines of the same byte order. The
   * hash is not cryptographic. */
  uint64_t contentHash() const;

  /** Returns the sources that withSources() has set. Empty: the map is a source of its own, of an
   * unknown robot. */
  const Sources& sources() const;
  /** Returns this map with sources: those of a fused map, or the identity of the map of one robot.
   * The copy shares octree and features. */
  PreparedMap withSources(Sources sources) const;

  /** Returns the features, for the stages of matching. The reference is valid as long as this map
   * or a copy of it exists. */
  const MapFeatures& features() const;
  /** Returns the features of a comparison by edges only. The first call computes them, once. */
  const MapFeatures& featuresByEdges() const;

 private:
  struct Prepared;
  std::shared_ptr<const Prepared> prepared_;
  std::shared_ptr<const Sources> sources_;  // null: none are set
};

}  // namespace mrpt::fusion
