// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "fusion_core/map/voxel_blocks.h"
#include "fusion_octree/build.h"
#include "fusion_octree/walk.h"

/** \file
 * The free voxels of an octree, for fast lookup. */

namespace mrpt::fusion {

/** The free finest voxels of an octree. A lookup is faster than OcTree::search(), which visits 16
 * nodes scattered in memory. Memory: 8 bytes for each block of 4x4x4 voxels with a free voxel, plus
 * the index of the blocks (VoxelBlocks); 16 bytes for each free cube of more than 8 blocks. */
class FreeSpace {
 public:
  /** Depth of a block of 4x4x4 voxels in the octree. */
  static constexpr unsigned kBlock = OcTreeCube::kMaxDepth - 2;
  /** Adds a free leaf of at least one block. Leaves and blocks must be added in the order of the
   * octree. */
  void addCube(const OcTreeCube& leaf);
  /** Adds free voxels of a block.
   * \param[in] key Key of the lowest voxel of the block.
   * \param[in] mask Mask of the free voxels, one bit for each voxel in the order of the octree. */
  void addBlock(const octomap::OcTreeKey& key, uint64_t mask) { add(blockOf(key), mask); }
  /** Builds the index, after all additions and before the first lookup. */
  void index() {
    blocks_ = VoxelBlocks(keys_);
    keys_ = {};
  }

  /** Returns the number of free voxels. Cost: O(blocks). */
  uint64_t size() const;

  /** True if a voxel is free. */
  bool has(const octomap::OcTreeKey& key) const;

  /** Calls `f(const OcTreeCube&)` for cubes that together hold all free voxels. Small cubes have a
   * side of 2^\a height voxels, at most 4, and at least one free voxel. Larger cubes are completely
   * free. */
  template <class F>
  void forEachCube(unsigned height, F&& f) const {
    const unsigned depth = std::max(kVoxel - std::min(height, kVoxel), kBlock);
    const unsigned cells = 1U << (3 * (kVoxel - depth));
    const uint64_t all = cells == 64 ? ~uint64_t{0} : (uint64_t{1} << cells) - 1;
    blocks_.forEach([&](uint32_t i, const VoxelBlocks::Place& block) {
      for (unsigned first = 0; first < 64; first += cells)
        if (masks_[i] >> first & all) {
          const auto at = VoxelBlocks::coordinatesOf(static_cast<int>(first));
          const auto key = [&](unsigned axis) {
            return static_cast<octomap::key_type>(4 * block[axis] + at[axis]);
          };
          f(OcTreeCube{{key(0), key(1), key(2)}, depth});
        }
    });
    for (const Range& cube : cubes_) {
      const auto height_of = static_cast<unsigned>(__builtin_ctzll(cube.end - cube.first)) / 3;
      f(OcTreeCube{keyInOctreeOrder(cube.first), kVoxel - height_of});
    }
  }

 private:
  static constexpr unsigned kVoxel = OcTreeCube::kMaxDepth;

  struct Range {  // range of voxels, in octreeOrder()
    uint64_t first, end;
  };
  static octomap::OcTreeKey blockOf(const octomap::OcTreeKey& k) {
    const auto by_four = [](octomap::key_type x) { return static_cast<octomap::key_type>(x >> 2); };
    return {by_four(k[0]), by_four(k[1]), by_four(k[2])};
  }
  static int cellOf(const octomap::OcTreeKey& k) { return VoxelBlocks::cellOf(k[0], k[1], k[2]); }
  void add(const octomap::OcTreeKey& block, uint64_t mask) {
    keys_.push_back(block);
    masks_.push_back(mask);
  }

  std::vector<octomap::OcTreeKey> keys_;  // keys of the blocks, until index()
  std::vector<uint64_t> masks_;           // free voxels of each block
  VoxelBlocks blocks_;                    // index of the blocks by place
  std::vector<Range> cubes_;              // cubes of more than 8 blocks, in order
};

}  // namespace mrpt::fusion
