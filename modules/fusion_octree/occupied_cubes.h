// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fusion_octree/cube_list.h"

/** \file
 * Lookup of occupied voxels. */

namespace mrpt::fusion {

/** The occupied voxels of a CubeList: one entry of a hash table for each block or leaf. */
class OccupiedCubes {
 public:
  /** \param[in] cubes The map.
   * \param[in] threshold Least log-odds of an occupied voxel. */
  OccupiedCubes(const CubeList& cubes, float threshold);

  /** Answers queries of one thread. It remembers the block of the last query. */
  class Lookup {
   public:
    explicit Lookup(const OccupiedCubes& cubes) : cubes_(cubes) {}
    /** Returns whether a voxel is occupied. */
    bool contains(const octomap::OcTreeKey& key) {
      const uint64_t block = placeOf(key, VoxelBlock::kDepth);
      if (block != block_) {
        block_ = block;
        voxels_ = cubes_.voxelsIn(key);
      }
      return voxels_ >> VoxelBlock::indexOf(key) & 1U;
    }

   private:
    const OccupiedCubes& cubes_;
    uint64_t block_ = 0;   // no place is 0
    uint64_t voxels_ = 0;  // occupied voxels in the block
  };

 private:
  struct Entry {
    uint64_t place = 0;  // 0 for a free entry
    uint64_t voxels = 0;
  };

  /** Returns a number of the cube of a depth that contains a voxel; not 0. */
  static uint64_t placeOf(const octomap::OcTreeKey& key, unsigned depth) {
    const unsigned height = OcTreeCube::kMaxDepth - depth;
    return uint64_t{depth + 1} << 48U | uint64_t{static_cast<unsigned>(key[0] >> height)} << 32U |
           uint64_t{static_cast<unsigned>(key[1] >> height)} << 16U | key[2] >> height;
  }
  size_t slotOf(uint64_t place) const {
    return (place * 0x9e3779b97f4a7c15ULL >> 20U) & (entries_.size() - 1);
  }
  void add(uint64_t place, uint64_t voxels);
  uint64_t at(uint64_t place) const;
  uint64_t voxelsIn(const octomap::OcTreeKey& key) const;

  std::vector<Entry> entries_;
  std::vector<unsigned> depths_;  // of leaves larger than a block
};

}  // namespace mrpt::fusion
