// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <memory>

namespace mrpt::fusion {

/** The rigid transform of an octree: the map seen from another frame, on that frame's own grid.
 *
 * Each voxel of the new grid looks up the source map at its centre (inverse lookup), so there are
 * no holes and nothing is counted twice; where the new voxels are larger than the source's, it
 * takes the highest log-odds on a lattice of samples as dense as the source's voxels, as OctoMap's
 * own coarser levels do. Pruned leaves count as the voxels they stand for; free space is carried
 * over as occupied space is; unknown stays unknown.
 *
 * No obstacle is lost: a lone occupied voxel can fall between all the new centres. If no voxel
 * within half a (new) voxel diagonal of its moved centre came out occupied, the one that contains
 * the centre takes its value. So every occupied source voxel (in leaves up to 64 voxels wide) has
 * an occupied voxel of the result within half a voxel diagonal, centre to centre, of the larger of
 * the two voxels. And none is invented: an occupied voxel of the result has an occupied source
 * voxel within the same distance, or, on a coarser grid, within half a diagonal of each.
 *
 * \param[in] source Any octree, of any resolution; not modified.
 * \param[in] T_dst_src Pose of the source's frame in the new frame, `p_dst = T_dst_src * p_src`.
 * \param[in] resolution Voxel size of the new grid, metres.
 * \return A new pruned tree with the source's sensor model. Its log-odds are source values, never
 * clamped or mixed.
 * \exception std::invalid_argument If T_dst_src is not finite, or resolution not positive or more
 * than 64 times the source's.
 * \exception std::out_of_range If the moved map leaves the new grid (2^15 voxels from its origin).
 *
 * Cost: proportional to the voxels of the *boundaries* between leaves of different value; the
 * inside of a pruned leaf is copied whole. Memory: the new tree.
 */
std::unique_ptr<octomap::OcTree> transformOcTree(const octomap::OcTree& source,
                                                 const Eigen::Isometry3d& T_dst_src,
                                                 double resolution);

}  // namespace mrpt::fusion
