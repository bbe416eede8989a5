// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <vector>

#include "fusion_octree/build.h"
#include "fusion_octree/chunk_store.h"
#include "fusion_octree/cube.h"
#include "fusion_octree/voxel_block.h"

/** \file
 * A map as a list of cubes. */

namespace mrpt::fusion {

/** A cube of a CubeList: a leaf or a block of voxels. */
struct ListedCube {
  OcTreeCube cube;                    ///< The cube
  float log_odds = 0;                 ///< Log-odds of a leaf
  const VoxelBlock* block = nullptr;  ///< The voxels of a block; null for a leaf
};

/** The known space of a map as cubes that do not overlap, in the order of the octree. A list needs
 * a fraction of the time and memory of an octree. Each cube is as large as its values allow: the
 * list of a map has the leaves of its pruned octree. */
class CubeList {
 public:
  CubeList() = default;
  CubeList(CubeList&&) = default;
  CubeList& operator=(CubeList&&) = default;

  /** Adds a leaf behind all other cubes. Equal siblings become one leaf. */
  void addLeaf(const OcTreeCube& cube, float log_odds);
  /** Adds a block behind all other cubes. Equal voxels of a cube of 2 x 2 x 2 voxels get the bits
   * of the first of them, as pruning does. Unknown blocks are left out, blocks of one value become
   * leaves. */
  void addBlock(const OcTreeCube& cube, const VoxelBlock& block);
  /** Adds a cube of another list behind all other cubes. keepBlocksOf() must follow. */
  void addCube(const ListedCube& cube);
  /** Takes over the blocks of another list, whose cubes are in this list. */
  void keepBlocksOf(CubeList&& other);
  /** Adds another list behind all other cubes. */
  void addAll(CubeList&& others);

  /** Returns the cubes. */
  const std::vector<ListedCube>& cubes() const { return cubes_; }

 private:
  void pruneLast();

  std::vector<ListedCube> cubes_;
  ChunkStore<VoxelBlock> blocks_;
};

/** A part of a CubeList: the cubes that lie in one cube, or the larger cube that contains it. */
struct CubeRange {
  const ListedCube* begin = nullptr;
  const ListedCube* end = nullptr;

  bool empty() const { return begin == end; }
  /** Returns whether the range is one leaf that contains a cube. */
  bool isLeafOf(const OcTreeCube& cube) const {
    return !empty() && !begin->block && begin->cube.depth <= cube.depth;
  }
  /** Returns the block of a cube of VoxelBlock::kDepth; null if the cube is a leaf or unknown. */
  const VoxelBlock* block() const { return empty() ? nullptr : begin->block; }
  /** Returns the part of the range in a child of a cube.
   * \param[in] i Number of the child.
   * \param[in] child The child; the range must be the range of its parent. */
  CubeRange in(unsigned i, const OcTreeCube& child) const;
};

/** Builds the octree of a list. */
class CubeListVisitor {
 public:
  using State = CubeRange;

  explicit CubeListVisitor(const CubeList& list) : list_(&list) {}
  State rootState() const {
    return {list_->cubes().data(), list_->cubes().data() + list_->cubes().size()};
  }
  static OcTreeFill visit(const OcTreeCube& cube, const State& s) {
    if (s.empty()) return OcTreeFill::unknown();
    if (s.isLeafOf(cube)) return OcTreeFill::leaf(s.begin->log_odds);
    return cube.depth == VoxelBlock::kDepth ? OcTreeFill::voxels(*s.block()) : OcTreeFill::split();
  }
  static State descend(const State& s, unsigned i, const OcTreeCube& child) {
    return s.in(i, child);
  }

 private:
  const CubeList* list_;
};

}  // namespace mrpt::fusion
