// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>

#include <cmath>
#include <cstddef>

/** \file
 * Settings of the search for poses to start from. */

namespace mrpt::fusion {

/** How map B may be turned against A where nothing is known of its pose. */
enum class SearchRotations {
  Yaw,  ///< About A's z axis: both maps are upright to within a few degrees
  All   ///< Any rotation: the maps have no common vertical, see searchAllRotations()
};

/** How much a search computes: results depend on it, as a wider lattice is coarser. */
struct SearchBudget {
  double small_work = 5e7;            ///< Values added up that need no thought of saving
  double max_work = 2e9;              ///< Most values added up on one lattice
  double max_cells = 64e6;            ///< Most cells of the score grid
  size_t kept_places = 2048;          ///< Places that a lattice hands to the next finer lattice
  size_t places_per_yaw = 128;        ///< Most places kept of one yaw
  size_t places_per_hypothesis = 32;  ///< Places kept for each hypothesis, if one lattice suffices
  unsigned min_hypotheses_everywhere = 256;  ///< Least hypotheses of a search from everywhere()
};

/** Settings of searchAllRotations(). */
struct AllRotationsParams {
  double alike = 0.13962634015954636;    ///< Normals this near face the same direction, rad (8 deg)
  double apart = 0.3490658503988659;     ///< Least angle between two directions, rad (20 deg)
  double upright = 0.05235987755982988;  ///< Tilt that registration corrects, rad (3 deg)
  double min_share = 0.02;               ///< Least share of all surface that faces a direction
  size_t directions = 4;                 ///< Directions of B that are laid on A's
  size_t sample_surfaces = 1500;         ///< Surfaces that tell the directions
};

/** Settings of searchAround(). Half widths may be infinite: as far as the maps can overlap. */
struct SearchParams {
  double translation = 2.5;         ///< Half width in x and y, m; 0: no search
  double height = 0.6;              ///< Half width in z, m
  double yaw = 0.3490658503988659;  ///< Half width of the rotation about A's z axis, rad (20 deg)
  /** Width of the coarse grid's cells, m; at least two voxels, rounded up to a cube of A's octree.
   */
  double cell = 0.3;
  unsigned hypotheses = 3;                           ///< Number of best distinct poses to return
  SearchRotations rotations = SearchRotations::Yaw;  ///< Rotations of a search from everywhere()

  double conflict_weight = 10;  ///< Weight of a conflict over a confirmed obstacle in the score
  double wall_share = 0.25;     ///< Least share of the best wall alignment over the mean, of a yaw
  double floor_share = 0.6;     ///< Least share of the best floor alignment, of a height
  double margin = 5;            ///< Free space farther than this from all obstacles is ignored, m
  unsigned distinct_cells = 3;  ///< Hypotheses differ by more than these cells
  double distinct_yaw = 0.17453292519943295;  ///< or by more than this, rad (10 deg)
  SearchBudget budget;                        ///< How much to compute
  AllRotationsParams all_rotations;           ///< Search without a common vertical

  /** True if nothing bounds the search. */
  bool isEverywhere() const { return std::isinf(translation); }
};

/** The same search for maps of which nothing is known but where up is. */
MRPT_FUSION_API SearchParams everywhere(SearchParams params);

}  // namespace mrpt::fusion
