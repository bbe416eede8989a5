// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>

#include <cmath>
#include <cstddef>

/** \file
 * Settings of the search, which finds starts for registration. */

namespace mrpt::fusion {

/** Rotations of a search without a guess. */
enum class SearchRotations {
  Yaw,  ///< About A's z axis: both maps are upright to within a few degrees
  All   ///< All rotations: the maps have no common vertical, see searchAllRotations()
};

/** Limits of the cost of a search. Results depend on them: a lattice of more poses is coarser. */
struct SearchBudget {
  double small_work = 5e7;            ///< Number of additions below which nothing is saved
  double max_work = 2e9;              ///< Largest number of additions on one lattice
  double max_cells = 64e6;            ///< Largest number of cells of the score grid
  size_t kept_places = 2048;          ///< Number of places passed to the next finer lattice
  size_t places_per_yaw = 128;        ///< Largest number of places of one yaw
  size_t places_per_hypothesis = 32;  ///< Number of places per hypothesis, if one lattice suffices
  unsigned min_hypotheses_everywhere = 256;  ///< Least number of hypotheses of everywhere()
};

/** Settings of searchAllRotations(). */
struct AllRotationsParams {
  double alike = 0.13962634015954636;    ///< Largest angle of normals of one direction, rad (8 deg)
  double apart = 0.3490658503988659;     ///< Least angle between two directions, rad (20 deg)
  double upright = 0.05235987755982988;  ///< Largest tilt of an upright map, rad (3 deg)
  double min_share = 0.02;               ///< Least share of the surface that faces a direction
  size_t directions = 4;                 ///< Number of directions of B laid on A's direction
  size_t sample_surfaces = 1500;         ///< Number of surfaces for the directions
};

/** Settings of searchLevelled(). */
struct LevellingParams {
  double max_tilt = 0.4363323129985824;  ///< Largest tilt of a map, rad (25 deg)
  unsigned block_voxels = 32;            ///< Side of the blocks that give one slope, voxels
  unsigned min_layer_voxels = 64;        ///< Least number of voxels of a layer
  double max_cells = 3;  ///< Largest difference of heights that needs no levelling, cells
};

/** Settings of searchAround(). Half widths may be infinite: the overlap of the maps then bounds the
 * search. */
struct SearchParams {
  double translation = 2.5;         ///< Half width in x and y, m; 0: no search
  double height = 0.6;              ///< Half width in z, m
  double yaw = 0.3490658503988659;  ///< Half width of the rotation about A's z axis, rad (20 deg)
  /** Width of the cells of the score grid, m. It is at least 2 voxels, and rounded up to a cube of
   * A's octree. */
  double cell = 0.3;
  unsigned hypotheses = 3;                           ///< Number of distinct poses to return
  SearchRotations rotations = SearchRotations::Yaw;  ///< Rotations of a search from everywhere()

  double conflict_weight = 10;  ///< Weight of a conflict over a confirmed obstacle
  double wall_share = 0.25;     ///< Least wall alignment of a yaw; 0: mean, 1: best
  double floor_share = 0.6;     ///< Least floor alignment of a height over the best
  double margin = 5;            ///< Largest distance of used free space from obstacles, m
  unsigned distinct_cells = 3;  ///< Largest distance of equal hypotheses, cells
  double distinct_yaw = 0.17453292519943295;  ///< Largest yaw of equal hypotheses, rad (10 deg)
  SearchBudget budget;                        ///< Limits of the cost
  LevellingParams levelling;                  ///< Settings of the search of tilted maps
  AllRotationsParams all_rotations;           ///< Settings of the search without a common vertical

  /** True if the search has no bounds. */
  bool isEverywhere() const { return std::isinf(translation); }
};

/** Returns the parameters of a search without bounds, for upright maps without a guess. */
MRPT_FUSION_API SearchParams everywhere(SearchParams params);

}  // namespace mrpt::fusion
