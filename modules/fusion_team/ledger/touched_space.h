// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "fusion_octree/build.h"

/** \file
 * The blocks of voxels that a change touches. */

namespace mrpt::fusion {

/** A set of blocks of the grid. A block is a cube of 16 x 16 x 16 voxels.
 *
 * The blocks are ranges in the order of the octree, so a leaf with billions of voxels is one range.
 */
class TouchedSpace {
 public:
  static constexpr unsigned kBlockDepth = 12;  ///< Depth of a block in the octree

  /** How much of a cube is in the set. */
  enum class Share { None, Part, All };

  /** Adds all blocks with known space of a map. */
  void add(const octomap::OcTree& map);
  /** Adds the whole grid. */
  void addAll();
  /** Sorts and joins the ranges. Call it after the last addition. */
  void finish();

  /** True if no block is in the set. */
  bool empty() const { return ranges_.empty(); }
  /** Returns how much of a cube is in the set. A cube in a block has no Share::Part.
   * Cost: O(log(number of ranges)). */
  Share shareOf(const OcTreeCube& cube) const;

 private:
  using Range = std::pair<uint64_t, uint64_t>;  // first voxel and end, in the octree's order

  static Range rangeOf(const OcTreeCube& cube);
  void addRange(const Range& range);
  void addNode(const octomap::OcTree& map, const octomap::OcTreeNode& node, const OcTreeCube& cube);

  std::vector<Range> ranges_;
};

}  // namespace mrpt::fusion
