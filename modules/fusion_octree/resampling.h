// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <memory>

#include "fusion_octree/cube_list.h"

/** \file
 * The rigid transform of an octree. */

namespace mrpt::fusion {

/** Returns the rigid transform of an octree: the map in another frame, on the grid of that frame.
 *
 * Each voxel of the new grid looks up the source map at its centre (inverse lookup). So there are
 * no holes, and nothing is counted twice. If the new voxels are larger than the source voxels, the
 * new value is the highest log-odds on a lattice of samples as dense as the source voxels, as on
 * OctoMap's coarser levels. Pruned leaves count as all finest voxels in them. Free space is treated
 * like occupied space. Unknown space stays unknown.
 *
 * No obstacle is lost. A single occupied voxel can fall between all new centres. If no new voxel
 * within half a (new) voxel diagonal of its moved centre is occupied, the new voxel that contains
 * the centre gets its value. So every occupied source voxel (in leaves up to 64 voxels wide) has an
 * occupied voxel of the result within half a voxel diagonal of the larger of the two voxels, centre
 * to centre. No obstacle is added: an occupied voxel of the result has an occupied source voxel
 * within the same distance, or, on a coarser grid, within the sum of half a diagonal of each.
 *
 * \param[in] source The octree; not modified.
 * \param[in] T_dst_src Pose of the source's frame in the new frame, `p_dst = T_dst_src * p_src`.
 * \param[in] resolution Voxel size of the new grid, m.
 * \return A new pruned octree with the source's sensor model. Its log-odds are values of the
 * source, not clamped and not mixed.
 * \exception std::invalid_argument If T_dst_src is not finite, or if the resolution is not positive
 * or more than 64 times the resolution of the source.
 * \exception std::length_error If the work is out of proportion to the nodes of the source: more
 * than 33 million voxels and some hundred voxels per node. A leaf of 2^36 voxels is an example.
 * \exception std::out_of_range If the moved map leaves the new grid (2^15 voxels from its origin).
 *
 * Cost: proportional to the number of voxels at the *boundaries* between leaves of different
 * values. The inside of a pruned leaf is copied as a whole. Memory: the new octree, and 256 bytes
 * for each block of 4 x 4 x 4 voxels of the source and of the result.
 */
std::unique_ptr<octomap::OcTree> transformOcTree(const octomap::OcTree& source,
                                                 const Eigen::Isometry3d& T_dst_src,
                                                 double resolution);

/** Returns the leaves of transformOcTree(), without the octree. Parameters and exceptions as
 * transformOcTree(). */
CubeList resampledCubes(const octomap::OcTree& source, const Eigen::Isometry3d& T_dst_src,
                        double resolution);

}  // namespace mrpt::fusion
