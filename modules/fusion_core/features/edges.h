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
 * The steps of Algorithm 1 that matching calls separately. */

namespace mrpt::fusion {

/** Computes eq. (5) for each voxel: the mean |n_j x n_i| over its neighbours, [0,1]. */
std::vector<float> computeAngleCosts(const OccupiedVoxels& voxels,
                                     const std::vector<Eigen::Vector3f>& normals,
                                     const EdgeParams& params);

/** Runs all of Algorithm 1, and eq. (6) for the edge voxels found. The result does not depend on
 * the number of threads.
 * \param[in] voxels All occupied voxels of the map.
 * \param[in] occupied Index of these voxels.
 * \param[in] pieces Some of the voxels, spread evenly, with the normals for eq. (5). The weight of
 * a piece is the number of voxels that it represents; these are consecutive in \a voxels.
 * \param[in] candidates Indices of the pieces to examine. At most one voxel of a piece becomes an
 * edge voxel: the voxel where the surface bends most.
 * \param[in] params Settings; all fields are used. */
EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                        const SurfaceVoxels& pieces, const std::vector<uint32_t>& candidates,
                        const EdgeParams& params);
/** Computes eq. (6) for given edge voxels: the covariance of each edge voxel from its neighbours.
 * Cost: O(edges * neighbours).
 * \param[in] at Distinct octree keys of the edge voxels, finest depth.
 * \param[in] probability Probability of each edge voxel.
 * \param[in] grid An octree of their resolution.
 * \param[in] direction_radius Radius of the neighbourhood, m; clamped to 3 to 64 voxels. */
EdgeVoxels edgeVoxelsAt(const std::vector<octomap::OcTreeKey>& at, std::vector<float> probability,
                        const octomap::OcTree& grid, double direction_radius);

}  // namespace mrpt::fusion
