// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Lists keys, ranges and meanings of the parameters of the search. */
#include "fusion_core/search/parameters.h"

#include <algorithm>
#include <limits>

namespace mrpt::fusion {
namespace {

const Names<SearchRotations> kRotationNames = {{SearchRotations::Yaw, "yaw"},
                                               {SearchRotations::All, "all"}};

}  // namespace

SearchParams everywhere(SearchParams params) {
  params.translation = params.height = params.yaw = std::numeric_limits<double>::infinity();
  params.hypotheses = std::max(params.hypotheses, params.budget.min_hypotheses_everywhere);
  return params;
}

Parameters parametersOf(SearchParams& params) {
  SearchBudget& b = params.budget;
  LevellingParams& l = params.levelling;
  AllRotationsParams& r = params.all_rotations;
  return {
      length(
          "search_translation", params.translation, 0, 1000,
          "Half width of the search around the guess in x and y, m; 0: start at the guess alone"),
      length("search_height", params.height, 0, 1000, "Half width of the search in z, m"),
      angle("search_yaw_deg", params.yaw, 0, 180, "Half width of the search in yaw, deg"),
      length("search_cell", params.cell, 1e-3, 1000,
             "Coarse cell of the search, at least 2 voxels, m"),
      count("search_hypotheses", params.hypotheses, 0, 1000,
            "Number of starts that the search returns, beside the guess"),
      choice("search_rotations", params.rotations, kRotationNames,
             "Without a guess: yaw (both maps are upright), all (they have no common vertical)"),
      advanced(number("search_conflict_weight", params.conflict_weight, 0, kUnlimited,
                      "Weight of an obstacle in free space over a confirmed obstacle")),
      advanced(number("search_wall_share", params.wall_share, 0, 1,
                      "Without a guess: least alignment of walls at a yaw, 0: mean, 1: best")),
      advanced(number("search_floor_share", params.floor_share, 0, 1,
                      "Least alignment of floors at a height, as a share of the best")),
      advanced(length("search_margin", params.margin, 0, 1000,
                      "Free space farther than this from all obstacles is ignored, m")),
      advanced(count("search_distinct_cells", params.distinct_cells, 0, 1000,
                     "Hypotheses at most this number of cells apart,")),
      advanced(angle("search_distinct_yaw_deg", params.distinct_yaw, 0, 180,
                     "and at most this angle, count as the same, deg")),
      advanced(number("search_small_work", b.small_work, 0, 1e15,
                      "Number of summed values below which the search is not reduced")),
      advanced(number("search_max_work", b.max_work, 1, 1e15,
                      "Most values summed on one lattice; above, the lattice is coarser")),
      advanced(number("search_max_cells", b.max_cells, 1, 1e10, "Most cells of the score grid")),
      advanced(count("search_kept_places", b.kept_places, 1, kUnlimited,
                     "Number of places passed from a lattice to the next finer lattice")),
      advanced(count("search_places_per_yaw", b.places_per_yaw, 1, kUnlimited,
                     "Most places kept of one yaw")),
      advanced(count("search_places_per_hypothesis", b.places_per_hypothesis, 1, kUnlimited,
                     "Places kept for each hypothesis if one lattice suffices")),
      advanced(count("search_everywhere_hypotheses", b.min_hypotheses_everywhere, 1, kUnlimited,
                     "Without a guess: least number of starts that the search returns")),
      advanced(angle("levelling_max_tilt_deg", l.max_tilt, 0, 90,
                     "Without a guess: largest tilt of a map that is levelled, deg")),
      advanced(count("levelling_block_voxels", l.block_voxels, 4, 1000,
                     "Side of the blocks of ground that give one slope, voxels")),
      advanced(count("levelling_min_voxels", l.min_layer_voxels, 3, kUnlimited,
                     "Least number of voxels of a layer of ground in a block")),
      advanced(number("levelling_max_cells", l.max_cells, 0, kUnlimited,
                      "B is levelled if a tilt moves its far end by more than this, cells")),
      advanced(angle("rotations_alike_deg", r.alike, 0, 90,
                     "search_rotations = all: normals this near face one direction, deg")),
      advanced(angle("rotations_apart_deg", r.apart, 0, 90,
                     "search_rotations = all: least angle between two directions, deg")),
      advanced(angle("rotations_upright_deg", r.upright, 0, 90,
                     "search_rotations = all: tilt that registration corrects, deg")),
      advanced(number("rotations_min_share", r.min_share, 0, 1,
                      "search_rotations = all: least share of the surface that faces a direction")),
      advanced(count("rotations_surfaces", r.sample_surfaces, 1, kUnlimited,
                     "search_rotations = all: number of surfaces that give the directions")),
      advanced(count("rotations_directions", r.directions, 1, 100,
                     "search_rotations = all: number of B's directions that are aligned with A's")),
  };
}

}  // namespace mrpt::fusion
