// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "fusion_core/map/voxel_blocks.h"
#include "fusion_octree/build.h"
#include "fusion_octree/walk.h"

namespace mrpt::fusion {

/** Tells which finest voxels of an octree are free: its own search() goes down sixteen nodes, which
 * lie all over memory. 8 bytes for each block of 4x4x4 voxels some of which are free, and their
 * index (VoxelBlocks, of blocks for voxels); 16 for each free cube of more than eight such blocks.
 */
class FreeSpace {
 public:
  /** The depth in the octree of a block of 4x4x4 voxels. */
  static constexpr unsigned kBlock = OcTreeCube::kMaxDepth - 2;
  /** Adds a free leaf of a block or more. All that is added comes in the order of the octree. */
  void addCube(const OcTreeCube& leaf);
  /** Adds free voxels of a block. \param[in] key Of its lowest voxel. \param[in] mask Which are
   * free, a bit for each in the order of the octree. */
  void addBlock(const octomap::OcTreeKey& key, uint64_t mask) { add(blockOf(key), mask); }
  /** Makes ready for questions, when all have been added. */
  void index() {
    blocks_ = VoxelBlocks(keys_);
    keys_ = {};
  }

  /** Whether a voxel is free. */
  bool has(const octomap::OcTreeKey& key) const;

  /** Calls `f(const OcTreeCube&)` for cubes that hold all free voxels between them: those of a side
   * of 2^\a height voxels, but not more than four, in which at least one is free, and larger ones
   * that are free all over. */
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

  struct Range {  // of voxels, in octreeOrder()
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

  std::vector<octomap::OcTreeKey> keys_;  // of the blocks, until they are indexed; by four voxels
  std::vector<uint64_t> masks_;           // of each block's voxels
  VoxelBlocks blocks_;                    // which block lies where
  std::vector<Range> cubes_;              // larger than eight blocks, in order
};

}  // namespace mrpt::fusion
