// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/voxels.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

/** \file
 * Where to start matching: a correlative search around the initial guess (not in the paper, whose
 * optimiser finds the nearest minimum; the idea is Olson's correlative scan matching, in 3-D and on
 * free space too).
 */

namespace mrpt::fusion {

/** How map B may be turned against A where nothing is known of its pose. */
enum class SearchRotations {
  Yaw,  ///< about A's z axis: up is up in both maps, but for the few degrees that matching takes up
  All   ///< any: the maps have no common vertical, see searchAllRotations()
};

/** Settings of searchAround(). Half widths may be infinite: as far as the maps can overlap. */
struct SearchParams {
  double translation = 2.5;         ///< half width in x and y, m; 0: no search
  double height = 0.6;              ///< half width in z, m
  double yaw = 0.3490658503988659;  ///< half width of the rotation about A's z axis, rad (20 deg)
  /** Of the coarse grid, m; at least two voxels, rounded up to a cube of A's octree. */
  double cell = 0.3;
  unsigned hypotheses = 3;                           ///< best distinct poses to return
  SearchRotations rotations = SearchRotations::Yaw;  ///< of a search from everywhere()

  /** True if nothing bounds the search. */
  bool isEverywhere() const { return std::isinf(translation); }
};

/** The same for maps of which nothing is known but where up is. */
SearchParams everywhere(SearchParams params);

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

/** The directions (unit, either sign stands for both) that most surfaces face, each 20 deg from the
 * others, the one of the most surface first; none that less than a fiftieth of all surfaces face.
 */
std::vector<Eigen::Vector3d> dominantDirections(const Surfaces& surfaces, size_t most);

/** searchAround() for maps that have no common vertical, from everywhere(). What faces A's dominant
 * direction (mostly its floors and ceilings, or walls) faces one of B's: each of B's four, with
 * either sign, is turned onto A's, and all turns about it and all translations are searched. So it
 * finds nothing where surfaces face everywhere alike, as in a cave.
 * \return The best poses of all these searches. Cost: eight searches, and if A's dominant direction
 * is not its z axis, an octree that is turned so that it is. */
std::vector<Hypothesis> searchAllRotations(const MapVoxels& a, const Surfaces& surfaces_a,
                                           const SurfaceVoxels& b, const SearchParams& params);

}  // namespace mrpt::fusion
