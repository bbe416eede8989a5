// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/export.h>
#include <octomap/OcTree.h>

#include <string>

/** \file
 * Edge voxels in other shapes. */

namespace mrpt::fusion {

/** The edge voxels as occupied ones, all else unknown. Empty, of 0.1 m, if there are none.
 * \exception std::exception As probabilityTree(). */
MRPT_FUSION_API octomap::OcTree occupancyTree(const EdgeVoxels& edges);

/** The edge voxels as leaves, each in the finest voxel that it lies in, whose value is its
 * probability: to convert it to log-odds would cost its last bits.
 * \exception std::exception If the resolution is not positive, or one lies outside an octree's grid
 * (32767 voxels from the origin) or has no probability in (0,1]. */
MRPT_FUSION_API octomap::OcTree probabilityTree(const EdgeVoxels& edges);

/** Inverse of probabilityTree(), in the octree's order; eq. (6) is computed again.
 * \param[in] tree The tree. \param[in] direction_radius See EdgeParams, m.
 * \exception std::exception If it is none of edge voxels. */
MRPT_FUSION_API EdgeVoxels edgesOf(const octomap::OcTree& tree, double direction_radius);

/** Edge voxels as the text of a PLY point cloud; nx ny nz is the direction of the edge, with its
 * probability and linearity(). */
MRPT_FUSION_API std::string toPly(const EdgeVoxels& edges);

}  // namespace mrpt::fusion
