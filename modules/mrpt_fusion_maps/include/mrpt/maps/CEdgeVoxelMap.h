// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/export.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/CProbOctoMap.h>

#include <string>

namespace mrpt::maps {

/** The structural edges of an occupancy map: what a robot sends first over a thin link.
 *
 * Serialized it is about a hundredth of the map: where the edge voxels are, on the octree's grid,
 * and how likely each is occupied. Directions and covariances, which follow from these by eq. (6),
 * are computed again when it is read, to the same bits.
 *
 * CProbabilisticMapMatching::Align3DPDF() takes it for either map, and then compares edges alone.
 * It cannot be merged, nor made from observations: insertObservation() returns false.
 */
class MRPT_FUSION_API CEdgeVoxelMap : public CMetricMap {
  DEFINE_SERIALIZABLE(CEdgeVoxelMap, mrpt::maps)

 public:
  CEdgeVoxelMap() = default;
  /** The edges of a map, by the paper's Algorithm 1. */
  explicit CEdgeVoxelMap(const CProbOctoMap& map, const mrpt::fusion::EdgeParams& params = {});
  /** Edge voxels that are known, each in the finest voxel of the grid that it lies in, in the order
   * of an octree; eq. (6) is computed again. \exception std::exception If the resolution is not
   * positive, or one lies outside an octree's grid (32767 voxels from the origin) or has no
   * probability in (0,1]. */
  explicit CEdgeVoxelMap(const mrpt::fusion::EdgeVoxels& edges);

  /** Centre (m, the map's frame), probability, covariance and by it the direction of each. */
  const mrpt::fusion::EdgeVoxels& edges() const { return m_edges; }
  size_t size() const { return m_edges.size(); }               ///< number of edge voxels
  double getResolution() const { return m_edges.resolution; }  ///< voxel size, m
  /** The edge voxels as occupied ones, all else unknown. Empty if there are none. */
  octomap::OcTree asOcTree() const;

  bool isEmpty() const override { return size() == 0; }  ///< Whether there is no edge voxel
  std::string asString() const override;                 ///< One line: resolution and size
  /** A line along each edge voxel's direction, the longer the straighter its neighbourhood is. */
  void getVisualizationInto(mrpt::fusion::viz::CSetOfObjects& o) const override;
  /** Writes `<prefix>.ply`: see toPly(). */
  void saveMetricMapRepresentationToFile(const std::string& filNamePrefix) const override;

 protected:
  void internal_clear() override { m_edges = {}; }  ///< See clear()
  /** \return false */
  bool internal_insertObservation(
      const mrpt::obs::CObservation& obs,
      const std::optional<const mrpt::poses::CPose3D>& robotPose = std::nullopt) override;
  /** \exception std::exception Always: it has no likelihood of observations. */
  double internal_computeObservationLikelihood(
      const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& takenFrom) const override;
  /** \return false */
  bool internal_canComputeObservationLikelihood(const mrpt::obs::CObservation& obs) const override;

 private:
  mrpt::fusion::EdgeVoxels m_edges;
};

}  // namespace mrpt::maps
