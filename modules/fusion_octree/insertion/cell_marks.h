// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fusion_octree/insertion/cell_window.h"

/** \file
 * Marks of the voxels of a scan: free or occupied.
 */

namespace mrpt::fusion {

/** Marks of the 16 x 16 x 16 voxels of a block, one bit each, in the octree's order. */
struct BlockMarks {
  static constexpr unsigned kWords = 64;  ///< Number of words: a word has 4 x 4 x 4 voxels
  uint64_t free[kWords];                  ///< Voxels that rays cross
  uint64_t occupied[kWords];              ///< Voxels that rays end in
};

/** Marks of the voxels of a window. Only blocks with marks use memory. */
class CellMarks {
 public:
  /** Removes all marks, and prepares for the blocks of a window. */
  void clear(uint64_t blocks) {
    for (const uint64_t number : numbers_) slots_[number] = 0;
    numbers_.clear();
    if (slots_.size() < blocks) slots_.resize(blocks, 0);
  }

  /** Marks a voxel as crossed by a ray. */
  void markFree(uint64_t cell) { blockOf(cell).free[wordOf(cell)] |= bitOf(cell); }
  /** Marks a voxel as the end of a ray. */
  void markOccupied(uint64_t cell) { blockOf(cell).occupied[wordOf(cell)] |= bitOf(cell); }

  /** Returns the numbers of the blocks with marks, in the order of their first marks. */
  const std::vector<uint64_t>& numbers() const { return numbers_; }
  /** Returns the marks of a block. Null if it has no marks. */
  const BlockMarks* find(uint64_t block) const {
    const uint32_t slot = block < slots_.size() ? slots_[block] : 0;
    return slot == 0 ? nullptr : &marks_[slot - 1];
  }
  /** Returns the memory of the marks, bytes. */
  size_t bytes() const {
    return slots_.capacity() * sizeof(uint32_t) + marks_.capacity() * sizeof(BlockMarks);
  }

 private:
  static unsigned wordOf(uint64_t cell) { return cell >> 6U & 63U; }
  static uint64_t bitOf(uint64_t cell) { return uint64_t{1} << (cell & 63U); }

  BlockMarks& blockOf(uint64_t cell) {
    const uint32_t slot = slots_[cell >> CellWindow::kCellsPerBlock];
    return slot == 0 ? add(cell >> CellWindow::kCellsPerBlock) : marks_[slot - 1];
  }
  /** Adds a block. It is rarely called, and apart so that marking a voxel stays short. */
  __attribute__((noinline)) BlockMarks& add(uint64_t block) {
    if (marks_.size() == numbers_.size()) marks_.resize(2 * marks_.size() + 64);
    numbers_.push_back(block);
    slots_[block] = static_cast<uint32_t>(numbers_.size());
    return marks_[numbers_.size() - 1] = BlockMarks{};
  }

  std::vector<uint32_t> slots_;  // place in marks_ by the number of the block, plus 1; 0: no marks
  std::vector<uint64_t> numbers_;
  std::vector<BlockMarks> marks_;
};

}  // namespace mrpt::fusion
