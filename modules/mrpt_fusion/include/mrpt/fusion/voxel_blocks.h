// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <array>
#include <cstdint>
#include <vector>

namespace mrpt::fusion {

/** Finds the voxels around voxels by their place on the grid: a hash of blocks of 4x4x4, each a
 * mask of 64 bits.
 *
 * The blocks around a block are looked up once for all its voxels; what is within a radius is then
 * an AND with the mask of a ball, so that only occupied neighbours cost time. Memory: 96 bytes per
 * occupied block (a wall fills a quarter of its blocks), 4 per voxel. */
class VoxelBlocks {
 public:
  /** Voxel i is known as i; keys must differ, in any order. O(n log n). */
  explicit VoxelBlocks(const std::vector<octomap::OcTreeKey>& keys);

  /** Number of occupied blocks. */
  size_t size() const { return blocks_.size(); }

  /** From a voxel to another, in voxels along each axis. */
  using Offset = std::array<int, 3>;

  /** All offsets of length at most a radius (voxels), zero included: for each cell of a block,
   * which cells of the blocks around it. Memory: 512 bytes times (radius / 2 + 3)^3. */
  class Ball {
   public:
    explicit Ball(double radius);

   private:
    friend class VoxelBlocks;
    int reach_;                                    // blocks
    std::vector<std::array<uint64_t, 64>> masks_;  // of each block around, x fastest; by cell
  };

  /** Calls `visit(i, neighbours)` for each voxel i of a block; `neighbours(f)` then calls
   * `f(j, offset)` for each voxel j within the ball around i, i itself included, in an order that
   * depends on the keys alone. Different blocks may be visited from different threads. */
  template <class Visit>
  void forEachVoxel(size_t block, const Ball& ball, Visit&& visit) const;

 private:
  struct Block {
    uint64_t mask = 0;               // bit of cell (x, y, z): x + 4 y + 16 z
    uint32_t first = 0;              // where its voxels begin in voxels_, in the order of the bits
    std::array<int, 3> place{};      // its key, in blocks
    std::array<uint8_t, 64> rank{};  // of each cell's voxel among the block's
  };
  /** A block near another. */
  struct Near {
    const Block* block;
    const std::array<uint64_t, 64>* masks;
    Offset offset;  // voxels
  };

  static uint64_t keyOf(const std::array<int, 3>& place) {
    const auto part = [](int b) { return static_cast<uint64_t>(b) & 0xFFFFFU; };
    return part(place[0]) | part(place[1]) << 20U | part(place[2]) << 40U;
  }
  static uint64_t hash(uint64_t key) { return (key * 0x9E3779B97F4A7C15ULL) >> 32U; }
  /** The block at a place, or null. */
  const Block* find(const std::array<int, 3>& place) const {
    const uint64_t key = keyOf(place);
    for (size_t slot = hash(key) & slot_mask_;; slot = (slot + 1) & slot_mask_) {
      if (slots_[slot].block == kNone) return nullptr;
      if (slots_[slot].key == key) return &blocks_[slots_[slot].block];
    }
  }
  std::vector<Near> near(const Block& block, const Ball& ball) const;

  static constexpr uint32_t kNone = ~uint32_t{0};
  struct Slot {
    uint64_t key = 0;
    uint32_t block = kNone;
  };

  std::vector<Block> blocks_;     // in the order of their keys
  std::vector<uint32_t> voxels_;  // of all blocks
  std::vector<Slot> slots_;
  uint64_t slot_mask_ = 0;
};

// ------------------------------------------------------------------------------------------------

template <class Visit>
void VoxelBlocks::forEachVoxel(size_t b, const Ball& ball, Visit&& visit) const {
  const Block& block = blocks_[b];
  const std::vector<Near> blocks_near = near(block, ball);
  for (uint64_t rest = block.mask; rest; rest &= rest - 1) {
    const int cell = __builtin_ctzll(rest);
    const int x = cell & 3, y = (cell >> 2) & 3, z = cell >> 4;
    visit(voxels_[block.first + block.rank[static_cast<size_t>(cell)]], [&](auto&& f) {
      for (const Near& n : blocks_near) {
        uint64_t found = n.block->mask & (*n.masks)[static_cast<size_t>(cell)];
        for (; found; found &= found - 1) {
          const int other = __builtin_ctzll(found);
          f(voxels_[n.block->first + n.block->rank[static_cast<size_t>(other)]],
            Offset{n.offset[0] + (other & 3) - x, n.offset[1] + ((other >> 2) & 3) - y,
                   n.offset[2] + (other >> 4) - z});
        }
      }
    });
  }
}

}  // namespace mrpt::fusion
