// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Numbers of the voxels that the rays of a scan can reach. */

#include "fusion_octree/insertion/cell_window.h"

namespace mrpt::fusion {

bool CellWindow::cover(const CellBox& box) {
  constexpr int32_t kMargin =
      2;  // a ray leaves the box by 1 voxel at most: rounding of its direction
  constexpr int32_t kBlockSide = 1 << kBlockBits;
  constexpr unsigned kMostBits = 36;
  unsigned shift = kCellsPerBlock;
  for (unsigned axis = 0; axis < 3; axis++) {
    low_[axis] = (box.low[axis] - kMargin) & ~(kBlockSide - 1);
    bits_[axis] = 0;
    while (low_[axis] + (kBlockSide << bits_[axis]) <= box.high[axis] + kMargin) bits_[axis]++;
    shift_[axis] = shift;
    mask_[axis] = uint64_t{kSpread[15]} << axis | ((uint64_t{1} << bits_[axis]) - 1) << shift;
    shift += bits_[axis];
  }
  mask_[2] |= ~uint64_t{0} << shift;  // zeros of all numbers
  return shift <= kMostBits;
}

}  // namespace mrpt::fusion
