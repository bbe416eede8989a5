// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/search_params.h>

#include <Eigen/Geometry>
#include <vector>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/map/map_voxels.h"

/** \file
 * The search for starts: a correlative search around a guess. It is not in the paper, whose
 * optimiser starts at the guess and finds the nearest minimum. The idea is Olson's correlative scan
 * matching, in 3-D and with free space. */

namespace mrpt::fusion {

/** A start: a pose and its score. */
struct Hypothesis {
  Eigen::Isometry3d T_a_b;  ///< Pose of map B in A's frame
  double score;             ///< Score, comparable between poses of the same maps; higher is better
};

/** Scores the poses of a lattice around \a T_a_b.
 *
 * The lattice has translations by whole cells and rotations about the direction \a up, through the
 * mean of B's voxels and through the origin of B's frame. The steps are so fine that no voxel of B
 * moves by more than a cell between neighbouring poses. An obstacle of B raises the score if A has
 * an obstacle there. It lowers the score if A has seen free space there, away from obstacles.
 *
 * If the poses are many, some of B's voxels choose the poses that all voxels of B score. If the
 * poses are too many for that, a coarser lattice is scored first, on A's octree at a lower depth,
 * then the neighbourhoods of its best poses. A search without bounds (everywhere()) only tries yaws
 * that lay walls along walls, if the maps have walls.
 *
 * The result does not depend on the number of threads.
 * Cost: yaws * translations * voxels of B, in contiguous runs of memory.
 * \param[in] a Map A.
 * \param[in] surfaces_a Surfaces of all or some voxels of A.
 * \param[in] b Some of B's occupied voxels, spread evenly, about one in each cell.
 * \param[in] T_a_b The guess: pose of map B in A's frame.
 * \param[in] params Range and resolution of the search.
 * \param[in] up Direction of the axis of rotation: A's vertical. Unit vector, A's frame.
 * \return The best poses, best first. They differ by more than SearchParams::distinct_cells or
 * SearchParams::distinct_yaw: more similar poses lead to the same place.
 */
std::vector<Hypothesis> searchAround(const MapVoxels& a, const Surfaces& surfaces_a,
                                     const SurfaceVoxels& b, const Eigen::Isometry3d& T_a_b,
                                     const SearchParams& params,
                                     const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());

/** Returns the least side of the cells of a search: SearchParams::cell, but at least 2 voxels, m.
 * \param[in] params The search.
 * \param[in] resolution_a,resolution_b Voxel sizes of the maps, m. */
double leastCell(const SearchParams& params, double resolution_a, double resolution_b);

/** Returns the best hypotheses of several searches, at most SearchParams::hypotheses, best first.
 */
std::vector<Hypothesis> bestOf(std::vector<Hypothesis> all, const SearchParams& params);

}  // namespace mrpt::fusion
