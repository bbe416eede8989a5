// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Stores free leaves as blocks or cubes, and looks voxels up. */
#include "fusion_core/map/free_space.h"

#include <algorithm>
#include <iterator>

#include "fusion_base/bits.h"

namespace mrpt::fusion {

void FreeSpace::addCube(const OcTreeCube& leaf) {
  // A leaf may hold 2^42 blocks. Only leaves of at most 8 blocks are stored as blocks: 8 blocks
  // take as much memory as the leaf itself.
  if (leaf.depth < kBlock - 1) {
    const uint64_t first = octreeOrder(leaf.key);
    cubes_.push_back({first, first + (uint64_t{1} << (3 * (kVoxel - leaf.depth)))});
  } else {
    forEachVoxel({blockOf(leaf.key), leaf.depth + 2},
                 [&](const auto& block) { add(block, ~uint64_t{0}); });
  }
}

uint64_t FreeSpace::size() const {
  uint64_t n = 0;
  for (const uint64_t mask : masks_) n += static_cast<uint64_t>(countBits(mask));
  for (const Range& cube : cubes_) n += cube.end - cube.first;
  return n;
}

bool FreeSpace::has(const octomap::OcTreeKey& key) const {
  const octomap::OcTreeKey block = blockOf(key);
  if (const auto i = blocks_.at({block[0], block[1], block[2]}))
    return masks_[*i] >> cellOf(key) & 1U;
  const uint64_t order = octreeOrder(key);
  const auto next = std::upper_bound(cubes_.begin(), cubes_.end(), order,
                                     [](uint64_t o, const Range& cube) { return o < cube.first; });
  return next != cubes_.begin() && order < std::prev(next)->end;
}

}  // namespace mrpt::fusion
