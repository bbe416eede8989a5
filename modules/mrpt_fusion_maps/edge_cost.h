// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstdint>
#include <vector>

/** \file
 * The cost of the covariances of edge voxels. */

namespace mrpt::fusion {

/** Returns an upper bound of the number of pairs of edge voxels for which eq. (6) is computed:
 * edge voxels within the radius of each other. Cost: O(n).
 * \param[in] edges Edge voxels.
 * \param[in] radius Radius, voxels. */
uint64_t edgePairs(const std::vector<octomap::OcTreeKey>& edges, double radius);

}  // namespace mrpt::fusion
