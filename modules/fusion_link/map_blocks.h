// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fusion_octree/cube.h"
#include "fusion_octree/tree_access.h"

/** \file
 * An octree as blocks: cubes whose compressed nodes fit into one sample. */

namespace mrpt::fusion {

/** Number of a cube of the grid: a leading 1, then 3 bits for each level from the root down. */
using BlockCode = uint64_t;

/** Returns the number of a cube. */
BlockCode codeOf(const OcTreeCube& cube);
/** Inverts codeOf(). Returns nothing if no cube has this number. */
std::optional<OcTreeCube> cubeOf(BlockCode code);

/** Largest number of nodes of a block. */
constexpr size_t kMostBlockNodes = 100'000;
/** Largest number of blocks of a map. */
constexpr size_t kMostBlocks = size_t{1} << 16U;

/** Compressed nodes of a block, shared because they are immutable. */
using BlockBytes = std::shared_ptr<const std::string>;

/** The parts of an octree that are not in its blocks. */
struct Trunk {
  double resolution = 0;                 ///< Voxel size, m
  OcTreeAccess::SensorModel model = {};  ///< Sensor model
  /** Nodes above the blocks with another value than the highest of their children, log-odds. */
  std::vector<std::pair<BlockCode, float>> values;
};

/** An octree as blocks. */
struct MapBlocks {
  Trunk trunk;
  std::map<BlockCode, BlockBytes> blocks;  ///< No block lies in another block
};

/** Returns the number of bytes of all blocks. */
size_t bytesOf(const MapBlocks& blocks);

/** Divides an octree into blocks. A cube is a block if its compressed nodes fit into a sample;
 * otherwise its children are divided.
 * \param[in] map The octree.
 * \param[in] before Earlier octree; null: none.
 * \param[in] blocks_before Blocks of the earlier octree. Blocks whose nodes are the same are taken
 * over. Cubes that were divided stay divided, so that few blocks change.
 * \exception std::length_error If there are more than kMostBlocks blocks.
 * Cost: one traversal, and the compression of the blocks that have changed. */
MapBlocks divideIntoBlocks(const octomap::OcTree& map, const octomap::OcTree* before = nullptr,
                           const MapBlocks& blocks_before = {});

/** Inverts divideIntoBlocks(), bit for bit, if all blocks are given. With some of the blocks the
 * result is the part of the map that they hold.
 * \exception std::runtime_error If a block is damaged or lies in another block, or there are too
 * many nodes. */
std::unique_ptr<octomap::OcTree> joinBlocks(const MapBlocks& blocks);

/** Checks that a block can be part of a map. \return Number of its nodes.
 * \exception std::runtime_error If it is damaged. */
size_t checkBlock(BlockCode code, std::string_view bytes);

}  // namespace mrpt::fusion
