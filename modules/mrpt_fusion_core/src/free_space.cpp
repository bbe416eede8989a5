// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/free_space.h>
#include <mrpt/maps/octree_voxels.h>

#include <algorithm>
#include <iterator>

namespace mrpt::fusion {

void FreeSpace::addCube(const mrpt::maps::OcTreeCube& leaf) {
  // Eight blocks take as much memory as the leaf itself; a leaf may stand for 2^42 of them.
  if (leaf.depth < kBlock - 1) {
    cubes_.push_back(leaf);
  } else {
    mrpt::maps::forEachVoxel({blockOf(leaf.key), leaf.depth + 2}, [&](const auto& block) {
      keys_.push_back(block);
      masks_.push_back(~uint64_t{0});
    });
  }
}

bool FreeSpace::has(const octomap::OcTreeKey& key) const {
  const octomap::OcTreeKey block = blockOf(key);
  if (const auto i = blocks_.at({block[0], block[1], block[2]}))
    return masks_[*i] >> cellOf(key) & 1U;
  const auto next = std::upper_bound(
      cubes_.begin(), cubes_.end(), octreeOrder(key),
      [](uint64_t order, const auto& cube) { return order < octreeOrder(cube.key); });
  return next != cubes_.begin() && std::prev(next)->contains({key, kVoxel});
}

}  // namespace mrpt::fusion
