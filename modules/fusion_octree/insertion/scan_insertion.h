// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <vector>

/** \file
 * Inserts scans into octrees, with the result of octomap and a tenth of its time.
 */

namespace mrpt::fusion {

/** What is known about the inner nodes of an octree. An insertion then visits the nodes above the
 * voxels of its scan only. */
enum class InnerNodes : unsigned char {
  Unknown,  ///< Nothing: the next insertion visits all nodes
  Current,  ///< All inner nodes hold the largest value of their children
  Pruned    ///< As Current. No node but the root has 8 equal leaves as children
};

/** Inserts a scan into an octree. The result is that of
 *
 *     tree.insertPointCloud(ends, origin, max_range, true);
 *     tree.updateInnerOccupancy();
 *     if (prune) tree.prune();
 *
 * in every node and in every bit, for any number of threads. Each voxel changes once: by a hit if a
 * ray ends in it, otherwise by a miss if a ray crosses it. Rays that leave the octree's grid have
 * no effect, without a warning. The rays and the blocks of voxels are processed in parallel. If the
 * octree has a bounding box or records changes, or if the scan extends over more than 2^36 voxels,
 * octomap itself inserts the scan.
 * \param[in,out] tree The octree.
 * \param[in] ends Ends of the beams, m, map frame.
 * \param[in] origin Position of the sensor, m, map frame.
 * \param[in] max_range Length up to which beams are inserted, m; negative: whole beams.
 * \param[in] prune Whether equal children are pruned.
 * \param[in] inner_nodes What is known about the octree.
 * \return What is known about the octree after the insertion. */
InnerNodes insertScan(octomap::OcTree& tree, const std::vector<octomap::point3d>& ends,
                      const octomap::point3d& origin, double max_range, bool prune,
                      InnerNodes inner_nodes);

/** Updates all inner nodes after lazy updates of voxels. Prunes if \a prune. \return What is known
 * about the octree then. */
InnerNodes finishLazyUpdates(octomap::OcTree& tree, bool prune, InnerNodes before_updates);

}  // namespace mrpt::fusion
