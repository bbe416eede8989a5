// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/prepared_map.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/map/map_voxels.h"

/** \file
 * The features of a map, computed once for each map. */

namespace mrpt::fusion {

/** The features of a map. */
struct MapFeatures : MapVoxels {
  SurfaceVoxels matched;  ///< Voxels of the voxel level, with their surfaces
  EdgeVoxels edges;       ///< Structural edges, for the edge level
  double scale = 1;       ///< Factor of lengths, see scaleOf()
};
/** Extracts the features of a map. Cost: see extractEdges(). */
MapFeatures computeFeatures(std::shared_ptr<const octomap::OcTree> map,
                            const FeatureParams& params);
/** Makes the features of a match by edges only: the edge voxels are the matched voxels, without
 * normals.
 * \param[in] map Occupied and free space. It may hold only the edges.
 * \param[in] edge_tree The edge voxels as occupied voxels.
 * \param[in] edges The edge voxels with their directions. */
MapFeatures featuresOfEdges(std::shared_ptr<const octomap::OcTree> map,
                            const octomap::OcTree& edge_tree, const EdgeVoxels& edges);
/** Returns the indices of the matched voxels that computeFeatures() examines for edges. */
std::vector<uint32_t> edgeCandidates(const SurfaceVoxels& matched, const FeatureParams& params);
/** Returns the number of calls of computeFeatures() in this process. Tests use it to check that no
 * map is prepared twice. */
size_t featureExtractions();
/** True if either map has no occupied voxel. */
bool isEmpty(const MapFeatures& a, const MapFeatures& b);
/** Returns the bounding box of the matched voxels of a map, in its frame, m. */
Eigen::AlignedBox3d boxOf(const MapFeatures& map);

}  // namespace mrpt::fusion
