// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <array>
#include <cstdint>
#include <vector>

namespace mrpt::fusion {

/** Finds voxels by their place on the grid: a hash of 8x8x8 blocks, each a dense array.
 *
 * Neighbours of a voxel need no tree walk: a look-up is one probe of the block table, O(1). Memory
 * is 2 kB per occupied block (a wall fills a few per cent of its blocks).
 */
class VoxelIndex {
 public:
  static constexpr uint32_t kNone = ~uint32_t{0};

  /** Voxel i gets the value i; keys must differ. */
  explicit VoxelIndex(const std::vector<octomap::OcTreeKey>& keys);

  /** The index of the voxel at a key, or kNone. Coordinates may leave the octree's key range. */
  uint32_t find(int x, int y, int z) const {
    const uint64_t block = blockKey(x >> 3, y >> 3, z >> 3);
    for (size_t slot = hash(block) & mask_;; slot = (slot + 1) & mask_) {
      const Slot& s = slots_[slot];
      if (s.block == block) return cells_[s.first + cellOf(x, y, z)];
      if (s.block == kEmpty) return kNone;
    }
  }

  using Offset = std::array<int, 3>;
  /** All grid offsets of length at most \a radius (voxels), zero included, nearest first. */
  static std::vector<Offset> offsetsWithin(double radius);

 private:
  static constexpr uint64_t kEmpty = ~uint64_t{0};
  struct Slot {
    uint64_t block = kEmpty;
    uint32_t first = 0;  ///< of the block's 512 cells
  };

  static uint64_t blockKey(int bx, int by, int bz) {
    const auto part = [](int b) { return static_cast<uint64_t>(b) & 0xFFFFFU; };
    return part(bx) | part(by) << 20U | part(bz) << 40U;
  }
  static uint64_t hash(uint64_t block) { return (block * 0x9E3779B97F4A7C15ULL) >> 32U; }
  static uint32_t cellOf(int x, int y, int z) {
    return static_cast<uint32_t>((x & 7) | (y & 7) << 3 | (z & 7) << 6);
  }

  std::vector<Slot> slots_;
  std::vector<uint32_t> cells_;
  uint64_t mask_ = 0;
};

}  // namespace mrpt::fusion
