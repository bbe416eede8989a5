// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

/** \file
 * Numbers of the voxels that the rays of a scan can reach.
 */

namespace mrpt::fusion {

/** Key of a voxel on each axis, as octomap::OcTreeKey, but without overflow. */
using CellKey = std::array<int32_t, 3>;

/** A box of voxels. Both corners belong to the box. */
struct CellBox {
  CellKey low{1 << 16, 1 << 16, 1 << 16};  ///< Lowest key
  CellKey high{-1, -1, -1};                ///< Highest key

  bool empty() const { return high[0] < low[0]; }  ///< True if nothing was added
  /** Enlarges the box to contain another box. */
  void add(const CellBox& o) {
    for (unsigned axis = 0; axis < 3; axis++) {
      low[axis] = low[axis] < o.low[axis] ? low[axis] : o.low[axis];
      high[axis] = high[axis] > o.high[axis] ? high[axis] : o.high[axis];
    }
  }
};

/** Numbers the voxels of a box. The lowest 12 bits of a number are the place of the voxel in its
 * block of 16 x 16 x 16 voxels, in the octree's order. The other bits are the number of the block.
 * The bits of each axis are apart from the bits of the other axes, see mask(). So a step to the
 * next voxel of an axis is an addition within the bits of this axis. */
class CellWindow {
 public:
  static constexpr unsigned kBlockBits = 4;       ///< Bits of a key within a block
  static constexpr unsigned kBlockDepth = 12;     ///< Depth of a block in the octree
  static constexpr unsigned kCellsPerBlock = 12;  ///< Bits of a number within a block

  /** Covers a box and 2 voxels around it. \return False if the box has more than 2^36 voxels. */
  bool cover(const CellBox& box);

  /** Returns the number of a voxel of the window. */
  uint64_t number(const CellKey& key) const {
    uint64_t number = 0;
    for (unsigned axis = 0; axis < 3; axis++) {
      const auto place = static_cast<uint32_t>(key[axis] - low_[axis]);
      number |= static_cast<uint64_t>(kSpread[place & 15U]) << axis |
                static_cast<uint64_t>(place >> kBlockBits) << shift_[axis];
    }
    return number;
  }
  /** Returns the bits of the numbers that belong to an axis. */
  uint64_t mask(unsigned axis) const { return mask_[axis]; }
  /** Returns the number of blocks, including blocks outside of the box. */
  uint64_t blocks() const { return uint64_t{1} << (shift_[2] + bits_[2] - kCellsPerBlock); }
  /** Returns the lowest voxel of a block. */
  CellKey lowestOf(uint64_t block) const {
    CellKey key;
    for (unsigned axis = 0; axis < 3; axis++) {
      const uint64_t place = block >> (shift_[axis] - kCellsPerBlock);
      key[axis] =
          low_[axis] + static_cast<int32_t>((place & ((1U << bits_[axis]) - 1U)) << kBlockBits);
    }
    return key;
  }
  /** Returns whether a key is a voxel of the window and of the octree. */
  bool contains(const CellKey& key) const {
    for (unsigned axis = 0; axis < 3; axis++)
      if (key[axis] < low_[axis] || key[axis] < 0 || key[axis] >= 1 << 16 ||
          key[axis] >= low_[axis] + (1 << (bits_[axis] + kBlockBits)))
        return false;
    return true;
  }

 private:
  /** Four bits with two zeros between them. */
  static constexpr uint16_t kSpread[16] = {0x000, 0x001, 0x008, 0x009, 0x040, 0x041, 0x048, 0x049,
                                           0x200, 0x201, 0x208, 0x209, 0x240, 0x241, 0x248, 0x249};

  CellKey low_{};
  std::array<unsigned, 3> bits_{};   // of the number of a block, by axis
  std::array<unsigned, 3> shift_{};  // of these bits
  std::array<uint64_t, 3> mask_{};
};

}  // namespace mrpt::fusion
