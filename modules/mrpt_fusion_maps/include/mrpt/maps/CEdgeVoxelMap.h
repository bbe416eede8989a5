// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/export.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/CProbOctoMap.h>

#include <memory>
#include <string>

namespace mrpt::maps {

/** The structural edges of an occupancy map. A robot with a slow link sends them before its map.
 *
 * The serialized edges have about 1 % of the size of the map. They hold the keys of the edge voxels
 * in the octree and the probability of each. Directions and covariances follow from these by eq.
 * (6). They are computed again, to the same bits, at the first call of edges() after the edges were
 * read. A stream whose edges are so dense that this would take more than seconds is refused.
 *
 * CProbabilisticMapMatching::Align3DPDF() takes this map for A, for B or for both, and compares
 * edges only. It cannot be merged. It cannot be built from observations: insertObservation()
 * returns false.
 */
class MRPT_FUSION_API CEdgeVoxelMap : public CMetricMap {
  DEFINE_SERIALIZABLE(CEdgeVoxelMap, mrpt::maps)

 public:
  CEdgeVoxelMap() = default;  ///< Creates a map without edges
  /** Extracts the edges of a map by Algorithm 1 of the paper. */
  explicit CEdgeVoxelMap(const CProbOctoMap& map, const mrpt::fusion::EdgeParams& params = {});
  /** Takes edge voxels. Each becomes the finest voxel of an octree that contains it, and their
   * order becomes that of the octree. Eq. (6) is computed again. \exception std::exception If the
   * resolution is not positive, if a voxel is outside of the grid of an octree (32767 voxels from
   * the origin), or if its probability is not in (0,1]. */
  explicit CEdgeVoxelMap(const mrpt::fusion::EdgeVoxels& edges);

  /** Returns the edge voxels: centres in the map's frame, m, probabilities and covariances. The
   * covariance holds the direction. */
  const mrpt::fusion::EdgeVoxels& edges() const;
  size_t size() const;           ///< Number of edge voxels
  double getResolution() const;  ///< Voxel size, m
  /** Returns an octree in which the edge voxels are occupied and all other voxels are unknown. */
  octomap::OcTree asOcTree() const;

  bool isEmpty() const override { return size() == 0; }  ///< Whether there is no edge voxel
  std::string asString() const override;                 ///< Resolution and size in one line
  /** Draws a line along the direction of each edge voxel. The line is long if the neighbourhood is
   * straight. */
  void getVisualizationInto(mrpt::fusion::viz::CSetOfObjects& o) const override;
  /** Writes `<prefix>.ply`, see toPly(). */
  void saveMetricMapRepresentationToFile(const std::string& filNamePrefix) const override;

 protected:
  void internal_clear() override;  ///< Removes all edges
  /** Inserts nothing. \return False */
  bool internal_insertObservation(
      const mrpt::obs::CObservation& obs,
      const std::optional<const mrpt::poses::CPose3D>& robotPose = std::nullopt) override;
  /** \exception std::exception Always: edges have no likelihood of observations. */
  double internal_computeObservationLikelihood(
      const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& takenFrom) const override;
  /** \return False */
  bool internal_canComputeObservationLikelihood(const mrpt::obs::CObservation& obs) const override;

 private:
  class Edges;
  std::shared_ptr<const Edges> m_edges;  // null: no edges; copies of the map share it
};

}  // namespace mrpt::maps
