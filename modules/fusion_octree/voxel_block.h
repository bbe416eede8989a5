// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "fusion_octree/cube.h"
#include "fusion_octree/tree_access.h"

/** \file
 * Blocks of 4 x 4 x 4 voxels as arrays. */

namespace mrpt::fusion {

namespace detail {

/** Returns the place in an array with x fastest of each voxel of a block. */
constexpr std::array<uint8_t, 64> rowIndices() {
  std::array<uint8_t, 64> places{};
  for (unsigned i = 0; i < 64; i++)
    places[i] =
        static_cast<uint8_t>((i & 1U) | (i >> 3U & 1U) << 1U | (i >> 1U & 1U) << 2U |
                             (i >> 4U & 1U) << 3U | (i >> 2U & 1U) << 4U | (i >> 5U & 1U) << 5U);
  return places;
}

}  // namespace detail

/** The voxels of a cube of 4 x 4 x 4 voxels, in the order of the octree: voxel 8 i + j is the j-th
 * child of the i-th child of the cube. */
struct VoxelBlock {
  static constexpr unsigned kDepth = OcTreeCube::kMaxDepth - 2;  ///< Depth of the cube
  static constexpr unsigned kVoxels = 64;                        ///< Number of voxels

  /** Place of each voxel in an array with x fastest. */
  static constexpr std::array<uint8_t, kVoxels> kRowIndex = detail::rowIndices();

  uint64_t known = 0;                ///< Bit i is set if voxel i is known
  std::array<float, kVoxels> value;  ///< Log-odds of the known voxels

  /** Returns the number of a voxel in the block that contains it. */
  static unsigned indexOf(const octomap::OcTreeKey& key) {
    const unsigned x = key[0], y = key[1], z = key[2];
    return (x & 1U) | (y & 1U) << 1U | (z & 1U) << 2U | (x & 2U) << 2U | (y & 2U) << 3U |
           (z & 2U) << 4U;
  }
  bool isKnown(unsigned i) const { return known >> i & 1U; }  ///< True if voxel i is known
  /** Sets voxel i to a known value. */
  void set(unsigned i, float log_odds) {
    known |= uint64_t{1} << i;
    value[i] = log_odds;
  }
  /** Makes all voxels known, with one value. */
  void fill(float log_odds) {
    known = ~uint64_t{0};
    value.fill(log_odds);
  }
  /** Sets the voxels of a node to their values. A leaf counts as all voxels in it.
   * \param[in] node A node of kDepth, or a leaf above. */
  void add(const octomap::OcTreeNode& node) {
    if (!OcTreeAccess::hasChildren(node)) return fill(node.getLogOdds());
    for (unsigned i = 0; i < 8; i++) {
      const auto* child = OcTreeAccess::child(node, i);
      if (!child) continue;
      const bool is_leaf = !OcTreeAccess::hasChildren(*child);
      for (unsigned j = 0; j < 8; j++)
        if (const auto* voxel = is_leaf ? child : OcTreeAccess::child(*child, j))
          set(8 * i + j, voxel->getLogOdds());
    }
  }
  /** Returns whether the voxels of the i-th child of the cube are known and equal. */
  bool isUniformChild(unsigned i) const {
    if ((known >> (8 * i) & 0xFFU) != 0xFFU) return false;
    const float* v = &value[size_t{8} * i];
    bool equal = true;
    for (unsigned j = 1; j < 8; j++) equal &= v[j] == v[0];
    return equal;
  }
};

}  // namespace mrpt::fusion
