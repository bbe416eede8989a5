// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

/** \file
 * Maps seen from above. */

namespace mrpt::fusion {

/** The columns of a map between two heights, as a grid of cells. */
struct MapSlice {
  /** Value of a column without known voxels. */
  static constexpr float kUnknown = -std::numeric_limits<float>::infinity();

  double resolution = 0;         ///< Side of a cell, m
  double low_x = 0, low_y = 0;   ///< Lowest corner of the grid, m, map frame
  size_t width = 0, height = 0;  ///< Number of cells along x and y
  /** Highest log-odds of the known voxels of each column, or kUnknown: an obstacle wins. Rows along
   * x, from the lowest y. */
  std::vector<float> log_odds;
};

/** Cuts a slice out of a map: the voxels whose centre is between two heights. The grid is the box
 * of their known voxels.
 * \param[in] map The map.
 * \param[in] low Lowest height of a centre, m, map frame; may be -infinity.
 * \param[in] high Highest height of a centre, m, map frame; may be infinity.
 * \return An empty grid if no voxel between the heights is known.
 * \exception std::length_error If the grid has more than 2^27 cells.
 *
 * Cost: O(nodes + cells): a leaf above many cells is written once. Memory: 4 bytes per cell. */
MapSlice sliceOf(const octomap::OcTree& map, double low, double high);

/** What a cell of a slice is. */
enum class CellKind : unsigned char { Unknown, Free, Occupied };

/** Limits of cells that are free or occupied. Cells between the limits are unknown. */
struct CellThresholds {
  float free;      ///< Log-odds below which a cell is free
  float occupied;  ///< Least log-odds of an occupied cell

  /** Returns the limits of a map: each known cell is free or occupied. */
  static CellThresholds of(const octomap::OcTree& map) {
    return {map.getOccupancyThresLog(), map.getOccupancyThresLog()};
  }
  /** Returns what a cell is. \param[in] log_odds See MapSlice::log_odds. */
  CellKind kindOf(float log_odds) const {
    if (log_odds == MapSlice::kUnknown) return CellKind::Unknown;
    if (log_odds >= occupied) return CellKind::Occupied;
    return log_odds < free ? CellKind::Free : CellKind::Unknown;
  }
};

}  // namespace mrpt::fusion
