// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Divides octrees into blocks, and joins blocks. */
#include "fusion_link/map_blocks.h"

#include <cstring>
#include <set>
#include <stdexcept>
#include <utility>

#include "fusion_base/byte_reader.h"
#include "fusion_octree/compression.h"
#include "fusion_octree/resolution.h"
#include "fusion_team/link/link.h"

namespace mrpt::fusion {
namespace {

using octomap::OcTreeNode;

/** Largest number of nodes of a map that is joined: 16 times the nodes of a large building. */
constexpr size_t kMostMapNodes = 16'000'000;

/** True if both values have the same bits. */
bool sameBits(float a, float b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

/** Returns the i-th child of a node; null if there is none. */
const OcTreeNode* childOf(const OcTreeNode* node, unsigned i) {
  return node && OcTreeAccess::childrenOf(*node) ? OcTreeAccess::child(*node, i) : nullptr;
}

/** True if both nodes have the same nodes below them, bit for bit. */
bool sameNodes(const OcTreeNode* a, const OcTreeNode* b) {
  if (!a || !b) return a == b;
  if (!sameBits(a->getLogOdds(), b->getLogOdds())) return false;
  for (unsigned i = 0; i < 8; i++)
    if (!sameNodes(childOf(a, i), childOf(b, i))) return false;
  return true;
}

/** Counts the nodes below a node and the node itself, as far as \a most + 1. */
size_t countNodes(const OcTreeNode& node, size_t most) {
  size_t count = 1;
  for (unsigned i = 0; i < 8 && count <= most; i++)
    if (const auto* child = childOf(&node, i)) count += countNodes(*child, most - count);
  return count;
}

/** Divides an octree. */
class Division {
 public:
  explicit Division(const MapBlocks& before) : before_(before.blocks) {
    for (const auto& block : before_)
      for (BlockCode above = block.first >> 3U; above && divided_.insert(above).second;)
        above >>= 3U;
  }

  void visit(const OcTreeNode& node, const OcTreeNode* node_before, const OcTreeCube& cube) {
    const BlockCode code = codeOf(cube);
    const bool was_divided = divided_.count(code) > 0;
    const bool is_leaf = !OcTreeAccess::hasChildren(node);
    if ((is_leaf || !was_divided) && addBlock(node, node_before, cube, code)) return;
    for (unsigned i = 0; i < 8; i++)
      if (const auto* child = childOf(&node, i))
        visit(*child, childOf(node_before, i), cube.child(i));
    if (!sameBits(node.getLogOdds(), node.getMaxChildLogOdds()))
      result.trunk.values.emplace_back(code, node.getLogOdds());
  }

  MapBlocks result;

 private:
  /** Adds a cube as a block. \return False if it is too large. */
  bool addBlock(const OcTreeNode& node, const OcTreeNode* node_before, const OcTreeCube& cube,
                BlockCode code) {
    const auto known = before_.find(code);
    if (known != before_.end() && sameNodes(&node, node_before)) {
      add(code, known->second);
      return true;
    }
    if (countNodes(node, kMostBlockNodes) > kMostBlockNodes) return false;
    auto bytes = compressNodes(node, cube.depth, Packing::Smallest);
    if (bytes.size() > kMostSampleBytes) return false;
    add(code, std::make_shared<const std::string>(std::move(bytes)));
    return true;
  }
  void add(BlockCode code, BlockBytes bytes) {
    if (result.blocks.size() == kMostBlocks)
      throw std::length_error("the map is too large to send: it has more than " +
                              std::to_string(kMostBlocks) + " blocks");
    result.blocks.emplace(code, std::move(bytes));
  }

  const std::map<BlockCode, BlockBytes>& before_;
  std::set<BlockCode> divided_;
};

/** Joins blocks. */
class Joining {
 public:
  explicit Joining(const MapBlocks& blocks)
      : blocks_(blocks), tree_(std::make_unique<octomap::OcTree>(blocks.trunk.resolution)) {
    OcTreeAccess::setSensorModel(*tree_, blocks.trunk.model);
  }

  std::unique_ptr<octomap::OcTree> run() {
    for (const auto& [code, bytes] : blocks_.blocks) add(code, *bytes);
    if (!tree_->getRoot()) return std::move(tree_);
    for (const auto& [code, value] : blocks_.trunk.values) values_[code] = value;
    setTrunk(*tree_->getRoot(), 1);
    return std::move(tree_);
  }

 private:
  void add(BlockCode code, std::string_view bytes) {
    const auto cube = cubeOf(code);
    if (!cube) corrupt("a block of the map is corrupt: it is no cube");
    if (!tree_->getRoot()) OcTreeAccess::createRoot(*tree_);
    OcTreeNode* node = tree_->getRoot();
    for (unsigned depth = 0; depth < cube->depth; depth++) {
      if (blocks_.blocks.count(code >> (3 * (cube->depth - depth))) > 0) corruptOverlap();
      const unsigned i = code >> (3 * (cube->depth - depth - 1)) & 7U;
      const bool is_new = !childOf(node, i);
      node = is_new ? tree_->createNodeChild(node, i) : tree_->getNodeChild(node, i);
      nodes_ += is_new ? 1 : 0;
    }
    nodes_ += decompressNodes(bytes, *tree_, *node, cube->depth, kMostBlockNodes) - 1;
    if (nodes_ > kMostMapNodes) corrupt("the map is too large: it has too many nodes");
  }

  /** Sets the nodes above the blocks. */
  void setTrunk(OcTreeNode& node, BlockCode code) {
    if (blocks_.blocks.count(code) > 0) return;
    for (unsigned i = 0; i < 8; i++)
      if (childOf(&node, i)) setTrunk(*tree_->getNodeChild(&node, i), code << 3U | i);
    const auto value = values_.find(code);
    node.setLogOdds(value == values_.end() ? node.getMaxChildLogOdds() : value->second);
  }

  [[noreturn]] static void corruptOverlap() {
    corrupt("a block of the map is corrupt: it lies in another block");
  }

  const MapBlocks& blocks_;
  std::unique_ptr<octomap::OcTree> tree_;
  std::map<BlockCode, float> values_;
  size_t nodes_ = 0;
};

}  // namespace

BlockCode codeOf(const OcTreeCube& cube) {
  BlockCode code = 1;
  for (unsigned depth = 0; depth < cube.depth; depth++) {
    code <<= 3U;
    for (unsigned axis = 0; axis < 3; axis++)
      code |= uint64_t{cube.key[axis] >> (OcTreeCube::kMaxDepth - 1 - depth) & 1U} << axis;
  }
  return code;
}

std::optional<OcTreeCube> cubeOf(BlockCode code) {
  unsigned depth = 0;
  while (depth <= OcTreeCube::kMaxDepth && code >> (3 * depth) > 1) depth++;
  if (depth > OcTreeCube::kMaxDepth || code >> (3 * depth) != 1) return std::nullopt;
  OcTreeCube cube;
  while (depth-- > 0) cube = cube.child(code >> (3 * depth) & 7U);
  return cube;
}

size_t bytesOf(const MapBlocks& blocks) {
  size_t bytes = 0;
  for (const auto& block : blocks.blocks) bytes += block.second->size();
  return bytes;
}

MapBlocks divideIntoBlocks(const octomap::OcTree& map, const octomap::OcTree* before,
                           const MapBlocks& blocks_before) {
  Division division(blocks_before);
  if (map.getRoot()) division.visit(*map.getRoot(), before ? before->getRoot() : nullptr, {});
  division.result.trunk.resolution = map.getResolution();
  division.result.trunk.model = OcTreeAccess::sensorModel(map);
  return std::move(division.result);
}

std::unique_ptr<octomap::OcTree> joinBlocks(const MapBlocks& blocks) {
  checkResolution(blocks.trunk.resolution);
  return Joining(blocks).run();
}

size_t checkBlock(BlockCode code, std::string_view bytes) {
  const auto cube = cubeOf(code);
  if (!cube) corrupt("a block of the map is corrupt: it is no cube");
  octomap::OcTree tree(1);
  return decompressNodes(bytes, tree, *OcTreeAccess::createRoot(tree), cube->depth,
                         kMostBlockNodes);
}

}  // namespace mrpt::fusion
