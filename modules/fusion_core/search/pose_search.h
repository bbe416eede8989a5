// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/search_params.h>

#include <Eigen/Geometry>
#include <vector>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/map/map_voxels.h"

/** \file
 * Where to start matching: a correlative search around the initial guess (not in the paper, whose
 * optimiser finds the nearest minimum; the idea is Olson's correlative scan matching, in 3-D and on
 * free space too). */

namespace mrpt::fusion {

/** A pose and how well the maps agree there. */
struct Hypothesis {
  Eigen::Isometry3d T_a_b;  ///< pose of map B in A's frame
  double score;             ///< comparable between poses of the same two maps; higher is better
};

/** Scores the poses of a lattice around \a T_a_b: translations by whole cells, rotations about A's
 * vertical (through B's middle and through the origin of its frame), fine enough that no voxel of B
 * moves by more than a cell from one to the next. An obstacle of B counts for a pose where A has
 * one too, and against it where A has seen free space, away from obstacles.
 *
 * If these are many, some of B's voxels tell which are looked at more closely; of too many, those
 * of a coarser lattice, on A's octree at a lesser depth, then the neighbourhoods of the best. From
 * everywhere() only yaws that lay walls along walls are tried, as far as the maps have any.
 *
 * \param[in] a Map A. \param[in] surfaces_a Of all or some of its voxels. \param[in] b Some of B's
 * occupied voxels, spread evenly, about one to a cell. \param[in] T_a_b The guess: pose of map B in
 * A's frame. \param[in] params How far, how finely. \return The best poses that are three cells or
 * 10 deg apart, best first: nearer ones lead to the same place. Deterministic, whatever the number
 * of threads. Cost: yaws * translations * voxels of B, in contiguous runs of bytes.
 */
std::vector<Hypothesis> searchAround(const MapVoxels& a, const Surfaces& surfaces_a,
                                     const SurfaceVoxels& b, const Eigen::Isometry3d& T_a_b,
                                     const SearchParams& params);

}  // namespace mrpt::fusion
