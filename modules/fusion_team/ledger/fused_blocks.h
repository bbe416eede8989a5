// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/merging.h>
#include <octomap/OcTree.h>

#include <memory>
#include <vector>

#include "fusion_octree/build.h"
#include "fusion_team/ledger/touched_space.h"

/** \file
 * Combines any number of octrees on one grid, block by block. */

namespace mrpt::fusion {

/** Returns the value of a voxel that is known in all of \a n maps.
 *
 * Bayes adds all log-odds and clamps the sum once. Stitch takes the first value. The other policies
 * combine the first two values, then the result with the third value, and so on.
 * For two values the result is fuseLogOdds().
 * \param[in] values Log-odds in the order of the maps.
 * \param[in] n Number of values, at least 1.
 * \param[in] params The policy.
 * \param[in] clamp_min,clamp_max Clamping thresholds of the result, as in fuseLogOdds(). */
float combineLogOdds(const float* values, size_t n, const MergeParams& params, float clamp_min,
                     float clamp_max);

/** Combines octrees on one grid, and computes only the blocks that changed.
 *
 * The result is the same, bit for bit, as for \a touched with the whole grid. It does not depend on
 * the number of threads.
 * \param[in] maps The octrees in the order of the combination. All have the resolution of
 * maps[0].
 * \param[in] counting Number of first maps whose observations count. The other maps only fill space
 * that none of these knows; the first of them that knows a voxel gives its value.
 * \param[in] params The policy.
 * \param[in] model Sensor model of the result.
 * \param[in] before Earlier result. Blocks that are not in \a touched are copied from it. Its maps
 * must be equal to \a maps in these blocks.
 * \param[in] touched The blocks to compute.
 * \return A new pruned octree.
 * Cost: one traversal of \a maps in the touched blocks, and of \a before elsewhere. */
std::unique_ptr<octomap::OcTree> combineOcTrees(
    const std::vector<std::shared_ptr<const octomap::OcTree>>& maps, size_t counting,
    const MergeParams& params, const OcTreeAccess::SensorModel& model,
    const octomap::OcTree& before, const TouchedSpace& touched);

}  // namespace mrpt::fusion
