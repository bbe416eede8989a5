// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/prepared_map.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/map/map_voxels.h"

/** \file
 * All that matching needs of a map, computed once for each map. */

namespace mrpt::fusion {

/** What matching needs of a map; computed once per map. */
struct MapFeatures : MapVoxels {
  SurfaceVoxels matched;  ///< Voxels that the levels work on
  EdgeVoxels edges;       ///< Structural edges, for the edge level
};
/** Extracts the features of a map. Cost: see extractEdges(). */
MapFeatures computeFeatures(std::shared_ptr<const octomap::OcTree> map,
                            const FeatureParams& params);
/** What matching by edges alone needs: the edges are the matched voxels, without normals.
 * \param[in] map All that is known of occupied and free space, which may be the edges only.
 * \param[in] edge_tree The edges, occupied. \param[in] edges The same with their directions. */
MapFeatures featuresOfEdges(std::shared_ptr<const octomap::OcTree> map,
                            const octomap::OcTree& edge_tree, const EdgeVoxels& edges);
/** Indices of the matched voxels in which computeFeatures() looks for edges. */
std::vector<uint32_t> edgeCandidates(const SurfaceVoxels& matched, const FeatureParams& params);
/** Number of calls of computeFeatures() in this process so far: tests count that nothing is
 * prepared twice. */
size_t featureExtractions();
/** True if either map has no occupied voxel. */
bool isEmpty(const MapFeatures& a, const MapFeatures& b);

}  // namespace mrpt::fusion
