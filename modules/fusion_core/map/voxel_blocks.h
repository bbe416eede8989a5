// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "fusion_base/bits.h"
#include "fusion_octree/walk.h"

/** \file
 * Index of voxels by place, in blocks of 4x4x4 voxels. */

namespace mrpt::fusion {

/** Finds the voxels around a place. The index has blocks of 4x4x4 voxels and groups of 4x4x4
 * blocks. Each has a mask of 64 bits in the order of the octree. A hash table holds the groups.
 *
 * A query ANDs the masks of the blocks with the masks of a ball, so only existing voxels cost time.
 * Each block stores the indices of its 26 neighbours: around a place in an existing block no hash
 * lookup is needed. Memory: 200 bytes per occupied block (a wall occupies 25 % of the voxels of its
 * blocks), 4 bytes per voxel. */
class VoxelBlocks {
 public:
  /** Voxel i has the index i in all results. Cost: O(n) for keys in the order of an octree's leaves
   * (as in OccupiedVoxels), otherwise O(n log n).
   * \param[in] keys Distinct keys, in any order. */
  explicit VoxelBlocks(const std::vector<octomap::OcTreeKey>& keys = {});

  /** Coordinates in voxels. They may lie outside of the range of keys. */
  using Place = std::array<int, 3>;
  using Offset = std::array<int, 3>;  ///< Difference of two places, voxels
  /** Returns the coordinates of a cell in its block, 0 to 3, from its bit in the mask. */
  static constexpr Offset coordinatesOf(int cell) { return {xOf(cell), yOf(cell), zOf(cell)}; }
  /** Returns the bit of a cell in its block's mask, from the last two bits of the coordinates. */
  static constexpr int cellOf(int x, int y, int z) {
    return spread(x) | spread(y) << 1 | spread(z) << 2;
  }

  /** Set of all offsets longer than one radius and at most as long as another radius, voxels. For
   * each cell of a block it stores the masks of the blocks around. Memory: 512 bytes times
   * (radius / 2 + 3)^3. */
  class Ball {
   public:
    /** Makes the set of offsets longer than \a beyond, up to \a radius, voxels. If \a beyond is
     * negative, the set includes the offset 0. */
    explicit Ball(double radius, double beyond = -1);

   private:
    friend class VoxelBlocks;
    struct Part {  // part of the ball in one block
      uint64_t mask;
      uint8_t beside;
      std::array<int8_t, 3> lowest;  // offset of that block's lowest cell from the query's cell
    };
    int radius_;                   // radius, whole voxels
    int reach_;                    // radius, blocks
    std::vector<uint64_t> masks_;  // masks by cell, then by block around, x fastest
    std::vector<Part> parts_;      // non-empty parts by cell; no parts if reach_ > 1
    std::array<size_t, 65> part_;  // first part of each cell; last: number of parts

    /** Returns the index in masks_ of the block at an offset (blocks) from a cell's own block. */
    size_t index(size_t cell, int x, int y, int z) const {
      const int side = 2 * reach_ + 1;
      return cell * static_cast<size_t>(side * side * side) +
             static_cast<size_t>(((z + reach_) * side + y + reach_) * side + x + reach_);
    }
    uint64_t of(size_t cell, int x, int y, int z) const { return masks_[index(cell, x, y, z)]; }
  };

  /** Calls `f(j, offset)` for each voxel j within the ball around a place. The place need not hold
   * a voxel. The order depends only on the keys. */
  template <class F>
  void forEachAround(const Place& place, const Ball& ball, F&& f) const;

  /** Calls `f(cells, offset)` for each block with voxels within the ball around a place, until f
   * returns true. \a cells is the mask of these voxels, \a offset is the offset of the block's
   * lowest cell. */
  template <class F>
  void forEachBlockAround(const Place& place, const Ball& ball, F&& f) const;

  /** Returns the voxel at a place, or nothing. */
  std::optional<uint32_t> at(const Place& place) const {
    const auto [x, y, z] = place;
    const uint32_t block = blockAt(x >> 2, y >> 2, z >> 2);
    const int cell = cellOf(x, y, z);
    if (block == kNone || !(blocks_[block].mask >> cell & 1U)) return std::nullopt;
    return voxelAt(contentOf(block, cell));
  }

  /** Calls `f(j, place)` for each voxel j, in the order of the octree. */
  template <class F>
  void forEach(F&& f) const;

  /** True if there is a voxel within the ball around a place. */
  bool anyAround(const Place& place, const Ball& ball) const;

  /** Fast access to the voxels around a place. It looks up each block at most once per place, at
   * the first access. Each thread needs its own window. */
  class Window {
   public:
    /** \param[in] blocks The index; must outlive the window.
     * \param[in] reach Half width of the window along each axis, voxels. */
    Window(const VoxelBlocks& blocks, int reach);
    /** Moves the window to another place. */
    void moveTo(const Place& place);
    /** True if there is a voxel.
     * \param[in] offset Offset from the place, within reach along each axis. */
    bool has(const Offset& offset) {
      const int x = at_[0] + offset[0], y = at_[1] + offset[1], z = at_[2] + offset[2];
      return maskOf(x >> 2, y >> 2, z >> 2) >> cellOf(x, y, z) & 1U;
    }
    /** Calls `f(offset)` for each voxel within the ball around an offset. The ball must lie within
     * the window. */
    template <class F>
    void forEachAround(const Offset& offset, const Ball& ball, F&& f);

   private:
    struct Seen {
      uint64_t mask = 0;
      uint32_t from = 0;  // number of the moveTo() call for which mask is valid
    };
    /** Returns the mask of a block, by its coordinates from the lowest block of the window. */
    uint64_t maskOf(int x, int y, int z) {
      const int block = (z * side_ + y) * side_ + x;
      Seen& seen = seen_[static_cast<size_t>(block)];
      if (seen.from != places_)
        seen = {blocks_.maskAt(low_[0] + x, low_[1] + y, low_[2] + z), places_};
      return seen.mask;
    }
    const VoxelBlocks& blocks_;
    int reach_, side_;        // blocks on each side of the place's block; blocks along an axis
    Place at_{}, low_{};      // place from the lowest cell of the lowest block; that block
    uint32_t places_ = 0;     // number of moveTo() calls
    std::vector<Seen> seen_;  // blocks of the window, x fastest
  };

  /** Coarse map of the places that have a voxel within a radius. It rejects most other places with
   * one lookup. Memory: 1 byte for each block in the bounding box of the voxels. If the voxels lie
   * far apart, it uses larger cubes than blocks: at most 32 bytes per existing block. */
  class Surroundings {
   public:
    Surroundings() = default;  ///< Map without voxels
    /** Cost: O(memory + blocks).
     * \param[in] blocks The index; not kept.
     * \param[in] radius The radius, voxels. */
    Surroundings(const VoxelBlocks& blocks, double radius);
    /** False only if no voxel is within the radius of a place. */
    bool mayReach(const Place& place) const {
      size_t index = 0;
      for (unsigned axis = 3; axis-- > 0;) {
        const int at = (place[axis] >> shift_) - low_[axis];
        if (at < 0 || at >= size_[axis]) return false;
        index = index * static_cast<size_t>(size_[axis]) + static_cast<size_t>(at);
      }
      return near_[index];
    }

   private:
    unsigned shift_ = 2;         // a cube's side is 2^shift_ voxels
    Place low_{}, size_{};       // lowest cube, and size of the box, cubes
    std::vector<uint8_t> near_;  // 1 for cubes near a voxel, x fastest
  };

 private:
  static constexpr uint32_t kNone = ~uint32_t{0};

  /** Mask of the existing cells of 64. Their contents are consecutive, in this order. */
  struct Cells {
    uint64_t mask = 0;
    uint32_t first = kNone;
  };
  using Ranks = std::array<uint8_t, 64>;    // rank of each cell among the existing cells
  using Beside = std::array<uint32_t, 27>;  // blocks around a block, x fastest, or kNone
  /** Returns the index in Beside of a block's neighbour, by its offset (blocks). */
  static constexpr size_t besideOf(int x, int y, int z) {
    const int index = (z + 1) * 9 + (y + 1) * 3 + x + 1;
    return static_cast<size_t>(index);
  }
  struct Slot : Cells {  // a group; its cells are blocks
    uint64_t key = 0;
  };
  /** Coordinate of a cell in its block. */
  static constexpr int xOf(int cell) { return (cell & 1) | (cell >> 2 & 2); }
  static constexpr int yOf(int cell) { return xOf(cell >> 1); }
  static constexpr int zOf(int cell) { return xOf(cell >> 2); }
  static constexpr int spread(int b) { return (b & 3) * 5 & 9; }  // bit 1 becomes bit 3
  static void add(Cells& cells, Ranks& ranks, int cell, uint32_t content);
  /** Returns the index of the n-th voxel in the order of the octree. */
  uint32_t voxelAt(uint32_t n) const { return voxels_.empty() ? n : voxels_[n]; }
  /** Returns the number of a cell's voxel, in the order of the octree. */
  uint32_t contentOf(uint32_t block, int cell) const {
    return blocks_[block].first + ranks_[block][static_cast<size_t>(cell)];
  }
  /** Returns the block in a cell of a group. */
  uint32_t contentOf(const Slot& group, int cell) const {
    return group.first +
           slot_ranks_[static_cast<size_t>(&group - slots_.data())][static_cast<size_t>(cell)];
  }
  void linkBlocks();

  static uint64_t keyOf(int x, int y, int z) {
    const auto part = [](int b) { return static_cast<uint64_t>(b) & 0xFFFFFU; };
    return part(x) | part(y) << 20U | part(z) << 40U;
  }
  static uint64_t hash(uint64_t key) { return (key * 0x9E3779B97F4A7C15ULL) >> 32U; }
  /** Returns the group at a place (groups), or null. */
  const Slot* find(int x, int y, int z) const {
    const uint64_t key = keyOf(x, y, z);
    for (size_t slot = hash(key) & slot_mask_;; slot = (slot + 1) & slot_mask_) {
      if (slots_[slot].first == kNone) return nullptr;
      if (slots_[slot].key == key) return &slots_[slot];
    }
  }
  /** Returns the block at a place (blocks), or kNone. */
  uint32_t blockAt(int x, int y, int z) const {
    const Slot* group = find(x >> 2, y >> 2, z >> 2);
    const int cell = cellOf(x, y, z);
    return group && (group->mask >> cell & 1U) ? contentOf(*group, cell) : kNone;
  }
  /** Returns the mask of the block at a place (blocks). */
  uint64_t maskAt(int x, int y, int z) const {
    const uint32_t block = blockAt(x, y, z);
    return block == kNone ? 0 : blocks_[block].mask;
  }
  /** Calls `f(block)` for the existing blocks in the box from \a low to \a high (blocks, both
   * included), until f returns true. */
  template <class F>
  void forEachBlock(const Place& low, const Place& high, F&& f) const;
  /** Calls `f(block, found, lowest)` for the blocks with voxels within the ball around a place,
   * until f returns true. \a found is the mask of these voxels, \a lowest is the offset of the
   * block's lowest cell. */
  template <class F>
  void forEachPart(const Place& place, const Ball& ball, F&& f) const;
  /** Returns the mask of the cells whose coordinate along an axis is in [low, high]. The range is
   * clipped to the block. */
  static uint64_t range(unsigned axis, int low, int high) {
    return kLess[axis][std::clamp(high, -1, 3) + 1] & ~kLess[axis][std::clamp(low, 0, 4)];
  }
  /** Masks of the cells whose coordinate is below 0, 1, 2, 3 and 4, for each axis. */
  static constexpr uint64_t kLess[3][5] = {
      {0, 0x0055005500550055, 0x00FF00FF00FF00FF, 0x55FF55FF55FF55FF, ~uint64_t{0}},
      {0, 0x0000333300003333, 0x0000FFFF0000FFFF, 0x3333FFFF3333FFFF, ~uint64_t{0}},
      {0, 0x000000000F0F0F0F, 0x00000000FFFFFFFF, 0x0F0F0F0FFFFFFFFF, ~uint64_t{0}}};

  // Blocks are in the order of the octree: the data of most queries is close together in memory.
  std::vector<Cells> blocks_;     // cells of each block
  std::vector<Ranks> ranks_;      // ranks of each block's cells
  std::vector<Beside> beside_;    // neighbours of each block
  std::vector<Place> places_;     // place of each block, blocks
  std::vector<uint32_t> voxels_;  // voxels in the octree's order; empty: the keys were in order
  std::vector<Slot> slots_;
  std::vector<Ranks> slot_ranks_;  // ranks of each group's cells
  uint64_t slot_mask_ = 0;
};

// ------------------------------------------------------------------------------------------------

template <class F>
void VoxelBlocks::forEach(F&& f) const {
  for (uint32_t b = 0; b < blocks_.size(); b++) {
    const auto [x, y, z] = places_[b];
    uint32_t n = blocks_[b].first;
    for (uint64_t found = blocks_[b].mask; found; found &= found - 1, n++) {
      const int cell = lowestBit(found);
      f(voxelAt(n), Place{4 * x + xOf(cell), 4 * y + yOf(cell), 4 * z + zOf(cell)});
    }
  }
}

template <class F>
void VoxelBlocks::forEachBlock(const Place& low, const Place& high, F&& f) const {
  for (int gz = low[2] >> 2; gz <= high[2] >> 2; gz++) {
    const uint64_t in_z = range(2, low[2] - 4 * gz, high[2] - 4 * gz);
    for (int gy = low[1] >> 2; gy <= high[1] >> 2; gy++) {
      const uint64_t in_zy = in_z & range(1, low[1] - 4 * gy, high[1] - 4 * gy);
      for (int gx = low[0] >> 2; gx <= high[0] >> 2; gx++) {
        const Slot* group = find(gx, gy, gz);
        if (!group || !(group->mask & in_zy)) continue;
        uint64_t found = group->mask & in_zy & range(0, low[0] - 4 * gx, high[0] - 4 * gx);
        for (; found; found &= found - 1)
          if (f(contentOf(*group, lowestBit(found)))) return;
      }
    }
  }
}

template <class F>
void VoxelBlocks::forEachPart(const Place& place, const Ball& ball, F&& f) const {
  const int x = place[0], y = place[1], z = place[2];
  const auto cell = static_cast<size_t>(cellOf(x, y, z));
  if (!ball.parts_.empty()) {
    const uint32_t own = blockAt(x >> 2, y >> 2, z >> 2);
    if (own != kNone) {
      const Beside& beside = beside_[own];
      for (size_t i = ball.part_[cell]; i < ball.part_[cell + 1]; i++) {
        const Ball::Part& part = ball.parts_[i];
        const uint32_t b = beside[part.beside];
        if (b == kNone) continue;
        const uint64_t found = blocks_[b].mask & part.mask;
        if (found && f(b, found, Offset{part.lowest[0], part.lowest[1], part.lowest[2]})) return;
      }
      return;
    }
  }
  const int r = ball.radius_;
  forEachBlock({(x - r) >> 2, (y - r) >> 2, (z - r) >> 2},
               {(x + r) >> 2, (y + r) >> 2, (z + r) >> 2}, [&](uint32_t block) {
                 const auto [bx, by, bz] = places_[block];
                 const uint64_t found = blocks_[block].mask &
                                        ball.of(cell, bx - (x >> 2), by - (y >> 2), bz - (z >> 2));
                 return found && f(block, found, Offset{4 * bx - x, 4 * by - y, 4 * bz - z});
               });
}

template <class F>
void VoxelBlocks::forEachBlockAround(const Place& place, const Ball& ball, F&& f) const {
  forEachPart(place, ball,
              [&](uint32_t, uint64_t found, const Offset& lowest) { return f(found, lowest); });
}

template <class F>
void VoxelBlocks::Window::forEachAround(const Offset& offset, const Ball& ball, F&& f) {
  const int x = at_[0] + offset[0], y = at_[1] + offset[1], z = at_[2] + offset[2];
  const auto cell = static_cast<size_t>(cellOf(x, y, z));
  const int r = ball.radius_;
  for (int bz = (z - r) >> 2; bz <= (z + r) >> 2; bz++)
    for (int by = (y - r) >> 2; by <= (y + r) >> 2; by++)
      for (int bx = (x - r) >> 2; bx <= (x + r) >> 2; bx++) {
        uint64_t found = ball.of(cell, bx - (x >> 2), by - (y >> 2), bz - (z >> 2));
        if (!found) continue;
        found &= maskOf(bx, by, bz);
        for (; found; found &= found - 1) {
          const int other = lowestBit(found);
          f(Offset{4 * bx + xOf(other) - at_[0], 4 * by + yOf(other) - at_[1],
                   4 * bz + zOf(other) - at_[2]});
        }
      }
}

template <class F>
void VoxelBlocks::forEachAround(const Place& place, const Ball& ball, F&& f) const {
  forEachPart(place, ball, [&](uint32_t block, uint64_t found, const Offset& lowest) {
    for (; found; found &= found - 1) {
      const int cell = lowestBit(found);
      f(voxelAt(contentOf(block, cell)),
        Offset{lowest[0] + xOf(cell), lowest[1] + yOf(cell), lowest[2] + zOf(cell)});
    }
    return false;
  });
}

}  // namespace mrpt::fusion
