// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <octomap/OcTree.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/map/voxel_blocks.h"

/** \file
 * The steps of Algorithm 1 that matching calls one by one. */

namespace mrpt::fusion {

/** Eq. (5) for each voxel: the mean |n_j x n_i| over its neighbours, in [0,1]. */
std::vector<float> computeAngleCosts(const OccupiedVoxels& voxels,
                                     const std::vector<Eigen::Vector3f>& normals,
                                     const EdgeParams& params);

/** All of Algorithm 1, and eq. (6) for what it finds.
 * Deterministic, whatever the number of threads.
 * \param[in] voxels All of the map's. \param[in] occupied The same, to walk on.
 * \param[in] pieces Some of them, spread evenly, whose normals eq. (5) compares: each stands for as
 * many of the voxels as its weight says, which follow each other.
 * \param[in] candidates Indices of the pieces to look in: of the voxels that one stands for at most
 * one is an edge, the one where the surface bends most. \param[in] params All of it. */
EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                        const SurfaceVoxels& pieces, const std::vector<uint32_t>& candidates,
                        const EdgeParams& params);
/** Eq. (6) for edge voxels that are known: each one's covariance from those around it.
 * O(edges * neighbours).
 * \param[in] at Their finest-level octree keys, distinct. \param[in] probability Of each.
 * \param[in] grid An octree of their resolution. \param[in] direction_radius How far around, m; at
 * least 3 and at most 64 voxels are kept to. */
EdgeVoxels edgeVoxelsAt(const std::vector<octomap::OcTreeKey>& at, std::vector<float> probability,
                        const octomap::OcTree& grid, double direction_radius);

}  // namespace mrpt::fusion
