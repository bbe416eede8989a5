// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fusion_octree/insertion/cell_marks.h"
#include "fusion_octree/insertion/cell_window.h"

/** \file
 * Updates an octree from the marks of a scan.
 */

namespace mrpt::fusion {

/** Updates octrees block by block. It keeps memory for the next scan. */
class TreeUpdater {
 public:
  /** Updates the marked voxels of an octree, occupied voxels before free voxels, and the nodes
   * above them. \param[in,out] tree The octree. All inner nodes must hold the largest value of
   * their children. If \a prune, no node must have 8 equal leaves as children, except for the root.
   * \param[in] window The window of the marks. \param[in] marks The marks of the scan, in parts.
   * \param[in] prune Whether equal children are pruned. */
  void update(octomap::OcTree& tree, const CellWindow& window,
              const std::vector<const CellMarks*>& marks, bool prune);

  /** Returns the memory of the object, bytes. */
  size_t bytes() const {
    return blocks_.capacity() * sizeof(Block) + marks_.capacity() * sizeof(BlockMarks);
  }

  /** A block of the scan. */
  struct Block {
    uint64_t order;                       ///< Place in the order of the octree
    uint64_t number;                      ///< Number in the window
    octomap::OcTreeKey key;               ///< Its lowest voxel
    octomap::OcTreeNode* node = nullptr;  ///< Its node. Null: in a larger leaf that does not change
    bool is_new = false;                  ///< Whether the node was created for this scan
    bool changed = false;                 ///< Whether the update has changed the node
  };

 private:
  void listBlocks(const CellWindow& window, const std::vector<const CellMarks*>& marks);

  std::vector<Block> blocks_;
  std::vector<BlockMarks> marks_;  // by index of the block
};

}  // namespace mrpt::fusion
