// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Fills score grids and adds up their values. */
#include "fusion_core/search/score_grid.h"

#include <algorithm>

namespace mrpt::fusion {
namespace {

/** Returns the value that is better for a pose. */
uint16_t lessAgainst(uint16_t v, uint16_t w) {
  if (v == ScoreGrid::kOccupied || w == ScoreGrid::kOccupied) return ScoreGrid::kOccupied;
  return std::min(v, w);
}

}  // namespace

ScoreGrid::ScoreGrid(const MapVoxels& map, const Eigen::AlignedBox3d& region, const Layout& layout)
    : layout_(layout) {
  const Cell low = layout.cellOf(region.min()), high = layout.cellOf(region.max());
  for (unsigned axis = 0; axis < 3; axis++) {
    low_[axis] = low[axis] - 1;
    size_[axis] = high[axis] + 2 - low_[axis];
  }
  values_.assign(cells() + kLanes, kUnknown);  // the padding of a row may lie beyond the last row
  map.free.forEachCube(layout.level, [this](const OcTreeCube& cube) { markFree(cube); });
  for (const auto& key : map.voxels.key) mark(layout.cellOf(key), 1, kOccupied);
  clearBesideOccupied();
}

ScoreGrid ScoreGrid::coarser() const {
  ScoreGrid c(*this);
  c.layout_ = {2 * layout_.cell, layout_.level + 1};
  for (unsigned axis = 0; axis < 3; axis++) {
    c.low_[axis] = low_[axis] >> 1;
    c.size_[axis] = ((low_[axis] + size_[axis] - 1) >> 1) + 1 - c.low_[axis];
  }
  c.values_.assign(c.cells() + kLanes,
                   kFree);  // the outermost cells become unknown by the unknown finer cells
  for (int z = 0; z < size_[2]; z++)
    for (int y = 0; y < size_[1]; y++)
      for (int x = 0; x < size_[0]; x++) {
        uint16_t& v =
            c.values_[c.index(((low_[0] + x) >> 1) - c.low_[0], ((low_[1] + y) >> 1) - c.low_[1],
                              ((low_[2] + z) >> 1) - c.low_[2])];
        v = lessAgainst(v, values_[index(x, y, z)]);
      }
  return c;
}

void ScoreGrid::addBox(const Cell& low, const Cell& size, uint16_t* __restrict sums) const {
  const int row_length = padded(size[0]);
  const int x = low[0] - low_[0], y = low[1] - low_[1], z = low[2] - low_[2];
  const int first_y = std::max(0, -y), end_y = std::min(size[1], size_[1] - y);
  const int first_x = std::max(0, -x), end_x = std::min(size[0], size_[0] - x);
  const bool whole_rows = first_x == 0 && end_x == size[0];
  if (first_x >= end_x) return;
  for (int k = std::max(0, -z); k < std::min(size[2], size_[2] - z); k++)
    for (int j = first_y; j < end_y; j++) {
      const uint16_t* __restrict values = &values_[index(x + first_x, y + j, z + k)];
      uint16_t* __restrict row = sums + static_cast<ptrdiff_t>(k * size[1] + j) * row_length;
      if (whole_rows) {
        for (int i = 0; i < row_length; i += kLanes)
          for (int lane = 0; lane < kLanes; lane++)
            row[i + lane] = static_cast<uint16_t>(row[i + lane] + values[i + lane]);
      } else {
        row += first_x;
        for (int i = 0; i < end_x - first_x; i++)
          row[i] = static_cast<uint16_t>(row[i] + values[i]);
      }
    }
}

void ScoreGrid::markFree(const OcTreeCube& cube) {
  const unsigned level = std::max(cube.kMaxDepth - cube.depth, layout_.level);
  mark(layout_.cellOf(cube.key), 1 << (level - layout_.level), kFree);
}

void ScoreGrid::mark(const Cell& cube, int side, uint16_t value) {
  Cell low, high;
  for (unsigned axis = 0; axis < 3; axis++) {
    low[axis] = std::max(cube[axis] - low_[axis], 0);
    high[axis] = std::min(cube[axis] - low_[axis] + side, size_[axis]);
  }
  for (int z = low[2]; z < high[2]; z++)
    for (int y = low[1]; y < high[1]; y++)
      for (int x = low[0]; x < high[0]; x++) values_[index(x, y, z)] = value;
}

void ScoreGrid::clearBesideOccupied() {
  const std::vector<uint16_t> before = values_;
  for (int z = 1; z + 1 < size_[2]; z++)
    for (int y = 1; y + 1 < size_[1]; y++)
      for (int x = 1; x + 1 < size_[0]; x++) {
        if (before[index(x, y, z)] != kOccupied) continue;
        for (int dz = -1; dz <= 1; dz++)
          for (int dy = -1; dy <= 1; dy++)
            for (int dx = -1; dx <= 1; dx++) {
              uint16_t& v = values_[index(x + dx, y + dy, z + dz)];
              v = lessAgainst(v, kUnknown);
            }
      }
}

}  // namespace mrpt::fusion
