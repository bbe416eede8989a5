// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/export.h>
#include <octomap/OcTree.h>

#include <string>

/** \file
 * Converts edge voxels to octrees and to PLY text. */

namespace mrpt::fusion {

/** Makes an octree with the edge voxels occupied and all other space unknown. Without edge voxels,
 * the octree is empty and has a resolution of 0.1 m.
 * \exception std::exception As probabilityTree(). */
MRPT_FUSION_API octomap::OcTree occupancyTree(const EdgeVoxels& edges);

/** Makes an octree with one finest leaf for each edge voxel. The value of the leaf is the
 * probability itself: a conversion to log-odds would lose its last bits.
 * \exception std::exception If the resolution is not positive, an edge voxel lies outside an
 * octree's grid (32767 voxels from the origin), or a probability is not in (0,1]. */
MRPT_FUSION_API octomap::OcTree probabilityTree(const EdgeVoxels& edges);

/** Inverts probabilityTree(). The edge voxels are in the order of the octree. Eq. (6) is computed
 * again.
 * \param[in] tree An octree of probabilityTree().
 * \param[in] direction_radius See EdgeParams, m.
 * \exception std::exception If the octree does not hold edge voxels. */
MRPT_FUSION_API EdgeVoxels edgesOf(const octomap::OcTree& tree, double direction_radius);

/** Writes edge voxels as the text of a PLY point cloud. The properties are x y z, the direction of
 * the edge as nx ny nz, probability and linearity(). */
MRPT_FUSION_API std::string toPly(const EdgeVoxels& edges);

}  // namespace mrpt::fusion
