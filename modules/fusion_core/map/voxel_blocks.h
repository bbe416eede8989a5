// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "fusion_base/bits.h"

namespace mrpt::fusion {

namespace detail {
/** Every third bit, from bit 0 on, is one of the 16 given. */
inline uint64_t spread16(uint64_t v) {
  v = (v | v << 16U) & 0x0000FF0000FFULL;
  v = (v | v << 8U) & 0x00F00F00F00FULL;
  v = (v | v << 4U) & 0x0C30C30C30C3ULL;
  return (v | v << 2U) & 0x249249249249ULL;
}
}  // namespace detail

/** Place of a finest voxel among the leaves of an octree, in the order of their traversal. */
inline uint64_t octreeOrder(const octomap::OcTreeKey& key) {
  return detail::spread16(key[0]) | detail::spread16(key[1]) << 1U | detail::spread16(key[2]) << 2U;
}

/** Finds the voxels around places by their keys: blocks of 4x4x4 voxels and groups of 4x4x4 blocks,
 * each a mask of 64 bits in the octree's order, and a hash of the groups.
 *
 * What is within a radius is an AND with the masks of a ball, so that only what is there costs
 * time. A block knows those beside it: around a place in one that is there, nothing is looked up.
 * Memory: 200 bytes per occupied block (a wall fills a quarter of its blocks), 4 per voxel. */
class VoxelBlocks {
 public:
  /** Voxel i is known as i; keys must differ, in any order. O(n) in the order of an octree's leaves
   * (as of OccupiedVoxels), O(n log n) otherwise. */
  explicit VoxelBlocks(const std::vector<octomap::OcTreeKey>& keys = {});

  /** Whole voxels along each axis: a key that may lie outside of the key range. */
  using Place = std::array<int, 3>;
  using Offset = std::array<int, 3>;  ///< from one place to another
  /** Of a bit of a block's mask: its cell's, 0 to 3. */
  static constexpr Offset coordinatesOf(int cell) { return {xOf(cell), yOf(cell), zOf(cell)}; }
  /** The bit of a block's mask, by (the last two bits of) coordinates. */
  static constexpr int cellOf(int x, int y, int z) {
    return spread(x) | spread(y) << 1 | spread(z) << 2;
  }

  /** All offsets longer than one radius and at most as long as another (voxels), as masks: for each
   * cell of a block, which cells of the blocks around it. Memory: 512 bytes times
   * (radius / 2 + 3)^3. */
  class Ball {
   public:
    /** Offsets longer than \a beyond (negative: zero included), up to \a radius; voxels. */
    explicit Ball(double radius, double beyond = -1);

   private:
    friend class VoxelBlocks;
    struct Part {  // what is in one of the blocks beside a cell's own
      uint64_t mask;
      uint8_t beside;
      std::array<int8_t, 3> lowest;  // cell of that block, from the one that is asked for
    };
    int radius_;                   // in whole voxels
    int reach_;                    // in blocks
    std::vector<uint64_t> masks_;  // of each cell in turn, of each block around, x fastest
    std::vector<Part> parts_;      // of each cell in turn, none empty; none if it reaches farther
    std::array<size_t, 65> part_;  // the first of each cell, and their number

    /** Of the block at an offset from a cell's own. */
    size_t index(size_t cell, int x, int y, int z) const {
      const int side = 2 * reach_ + 1;
      return cell * static_cast<size_t>(side * side * side) +
             static_cast<size_t>(((z + reach_) * side + y + reach_) * side + x + reach_);
    }
    uint64_t of(size_t cell, int x, int y, int z) const { return masks_[index(cell, x, y, z)]; }
  };

  /** Calls `f(j, offset)` for each voxel j within the ball around a place, occupied or not, in an
   * order that depends on the keys alone. */
  template <class F>
  void forEachAround(const Place& place, const Ball& ball, F&& f) const;

  /** The same by block: calls `f(cells, offset)` for each that has voxels in the ball, the mask of
   * the cells that hold them and the offset of the block's lowest cell, until f returns true. */
  template <class F>
  void forEachBlockAround(const Place& place, const Ball& ball, F&& f) const;

  /** The voxel at a place, if there is one. */
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

  /** Answers quickly whether voxels near a place are there: it looks up each block around it once,
   * when first asked for what it holds. Not for several threads. */
  class Window {
   public:
    /** Over \a blocks, which must outlive it; \a reach: how far from the place it sees along each
     * axis, voxels. */
    Window(const VoxelBlocks& blocks, int reach);
    /** Looks around another place from now on. */
    void moveTo(const Place& place);
    /** \param[in] offset From the place; within reach along each axis. */
    bool has(const Offset& offset) {
      const int x = at_[0] + offset[0], y = at_[1] + offset[1], z = at_[2] + offset[2];
      return maskOf(x >> 2, y >> 2, z >> 2) >> cellOf(x, y, z) & 1U;
    }
    /** Calls `f(offset)` for each voxel within the ball around an offset that it sees all of. */
    template <class F>
    void forEachAround(const Offset& offset, const Ball& ball, F&& f);

   private:
    struct Seen {
      uint64_t mask = 0;
      uint32_t from = 0;  // the place that it was looked up from, of all places
    };
    /** Of a block, counted from the lowest one. */
    uint64_t maskOf(int x, int y, int z) {
      const int block = (z * side_ + y) * side_ + x;
      Seen& seen = seen_[static_cast<size_t>(block)];
      if (seen.from != places_)
        seen = {blocks_.maskAt(low_[0] + x, low_[1] + y, low_[2] + z), places_};
      return seen.mask;
    }
    const VoxelBlocks& blocks_;
    int reach_, side_;        // blocks: on each side of the place's own, and in all
    Place at_{}, low_{};      // from the lowest cell of the lowest block; and that block
    uint32_t places_ = 0;     // so far
    std::vector<Seen> seen_;  // of the blocks, x fastest
  };

  /** Tells at once of most places with no voxel near that there is none. A byte for each block
   * within the box of all, or for a larger cube where the voxels lie far apart; at most 32 times as
   * many as blocks that are there. */
  class Surroundings {
   public:
    Surroundings() = default;  ///< of no voxels
    /** O(its memory), and of the blocks.
     * \param[in] blocks Not kept. \param[in] radius Voxels. */
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
    unsigned shift_ = 2;         // a cube's side is so many doublings of a voxel
    Place low_{}, size_{};       // cubes
    std::vector<uint8_t> near_;  // x fastest
  };

 private:
  static constexpr uint32_t kNone = ~uint32_t{0};

  /** Which of 64 cells are there; what they hold lies in their order, one after the other. */
  struct Cells {
    uint64_t mask = 0;
    uint32_t first = kNone;
  };
  using Ranks = std::array<uint8_t, 64>;    // of each cell among those that are there
  using Beside = std::array<uint32_t, 27>;  // the blocks around one, x fastest, or kNone
  /** The index of one of those around a block, by its offset. */
  static constexpr size_t besideOf(int x, int y, int z) {
    const int index = (z + 1) * 9 + (y + 1) * 3 + x + 1;
    return static_cast<size_t>(index);
  }
  struct Slot : Cells {  // a group, of blocks_
    uint64_t key = 0;
  };
  /** Coordinates of a cell. */
  static constexpr int xOf(int cell) { return (cell & 1) | (cell >> 2 & 2); }
  static constexpr int yOf(int cell) { return xOf(cell >> 1); }
  static constexpr int zOf(int cell) { return xOf(cell >> 2); }
  static constexpr int spread(int b) { return (b & 3) * 5 & 9; }  // bit 1 becomes bit 3
  static void add(Cells& cells, Ranks& ranks, int cell, uint32_t content);
  /** Which voxel is the n-th in the order of the octree. */
  uint32_t voxelAt(uint32_t n) const { return voxels_.empty() ? n : voxels_[n]; }
  /** Which voxel, in that order, a block's cell holds. */
  uint32_t contentOf(uint32_t block, int cell) const {
    return blocks_[block].first + ranks_[block][static_cast<size_t>(cell)];
  }
  /** Which block a group's cell holds. */
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
  /** The group at a place (groups), or null. */
  const Slot* find(int x, int y, int z) const {
    const uint64_t key = keyOf(x, y, z);
    for (size_t slot = hash(key) & slot_mask_;; slot = (slot + 1) & slot_mask_) {
      if (slots_[slot].first == kNone) return nullptr;
      if (slots_[slot].key == key) return &slots_[slot];
    }
  }
  /** The block at a place (blocks), or kNone. */
  uint32_t blockAt(int x, int y, int z) const {
    const Slot* group = find(x >> 2, y >> 2, z >> 2);
    const int cell = cellOf(x, y, z);
    return group && (group->mask >> cell & 1U) ? contentOf(*group, cell) : kNone;
  }
  /** Of the block at a place (blocks). */
  uint64_t maskAt(int x, int y, int z) const {
    const uint32_t block = blockAt(x, y, z);
    return block == kNone ? 0 : blocks_[block].mask;
  }
  /** Calls `f(block)` for the blocks from one place to another (blocks), both included, until f
   * returns true. */
  template <class F>
  void forEachBlock(const Place& low, const Place& high, F&& f) const;
  /** Calls `f(block, found, lowest)` for the blocks with voxels in the ball around a place, the
   * mask of these and the offset of the block's lowest cell, until f returns true. */
  template <class F>
  void forEachPart(const Place& place, const Ball& ball, F&& f) const;
  /** The cells of a cube whose coordinate along an axis is in [low, high], cut to the cube. */
  static uint64_t range(unsigned axis, int low, int high) {
    return kLess[axis][std::clamp(high, -1, 3) + 1] & ~kLess[axis][std::clamp(low, 0, 4)];
  }
  /** Of each axis, the cells whose coordinate is less than 0 to 4. */
  static constexpr uint64_t kLess[3][5] = {
      {0, 0x0055005500550055, 0x00FF00FF00FF00FF, 0x55FF55FF55FF55FF, ~uint64_t{0}},
      {0, 0x0000333300003333, 0x0000FFFF0000FFFF, 0x3333FFFF3333FFFF, ~uint64_t{0}},
      {0, 0x000000000F0F0F0F, 0x00000000FFFFFFFF, 0x0F0F0F0FFFFFFFFF, ~uint64_t{0}}};

  // The blocks, in the order of the octree: what most questions are answered by lies close
  // together.
  std::vector<Cells> blocks_;     // of the voxels
  std::vector<Ranks> ranks_;      // of each block's
  std::vector<Beside> beside_;    // of each
  std::vector<Place> places_;     // the key of each, in blocks
  std::vector<uint32_t> voxels_;  // of all blocks; none: they are in the octree's order
  std::vector<Slot> slots_;
  std::vector<Ranks> slot_ranks_;  // of each group's blocks
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
