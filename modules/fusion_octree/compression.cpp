// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Turns octrees into bytes that pack well, and reads untrusted packed data. */
#include "fusion_octree/compression.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "fusion_base/byte_reader.h"
#include "fusion_octree/build.h"

namespace mrpt::fusion {
namespace {

using octomap::OcTreeNode;

constexpr uint64_t kMostValues = 1U << 16U;  // in the table of distinct values

uint32_t bitsOf(float value) {
  uint32_t bits;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

float valueOf(uint32_t bits) {
  float value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

/** Appends \a bytes planes: plane i holds byte i of each number. */
void appendPlanes(const std::vector<uint32_t>& numbers, unsigned bytes, std::string& out) {
  size_t at = out.size();
  out.resize(at + bytes * numbers.size());
  for (unsigned i = 0; i < bytes; i++)
    for (const uint32_t n : numbers) out[at++] = static_cast<char>(n >> (8 * i) & 0xFFU);
}

std::vector<uint32_t> takePlanes(ByteReader& in, size_t count, unsigned bytes) {
  if (in.size() < count * bytes) corrupt("the map's data is truncated");
  std::vector<uint32_t> numbers(count);
  for (unsigned i = 0; i < bytes; i++)
    for (uint32_t& n : numbers) n |= uint32_t{in.take<uint8_t>()} << (8 * i);
  return numbers;
}

unsigned bytesFor(size_t table_size) { return table_size <= 1U << 8U ? 1 : 2; }

void append(uint64_t number, std::string& out) {
  out.append(reinterpret_cast<const char*>(&number), sizeof(number));
}

/** An inner node whose value is not the maximum of its children (after lazy updates). */
struct Exception {
  uint64_t node;  ///< Number of the node in pre-order
  float value;
};

/** The parts of an octree, each in pre-order. */
struct Parts {
  uint64_t nodes = 0;
  std::string masks;  ///< Masks of the children, for all nodes above the finest depth
  std::vector<uint32_t> leaves;
  std::vector<Exception> exceptions;
};

void collect(const OcTreeNode* node, unsigned depth, Parts& parts) {
  const uint64_t number = parts.nodes++;
  if (number >= kMostCompressedNodes) throw std::length_error("the map is too large to compress");
  uint8_t children = 0;
  if (OcTreeAccess::childrenOf(*node))
    for (unsigned i = 0; i < 8; i++)
      if (OcTreeAccess::child(*node, i)) children |= static_cast<uint8_t>(1U << i);
  if (depth < OcTreeCube::kMaxDepth) parts.masks.push_back(static_cast<char>(children));
  if (children == 0) {
    parts.leaves.push_back(bitsOf(node->getLogOdds()));
    return;
  }
  float highest = -std::numeric_limits<float>::max();  // as OctoMap's getMaxChildLogOdds()
  for (unsigned i = 0; i < 8; i++)
    if (children >> i & 1U)
      highest = std::max(highest, OcTreeAccess::child(*node, i)->getLogOdds());
  if (bitsOf(node->getLogOdds()) != bitsOf(highest))
    parts.exceptions.push_back({number, node->getLogOdds()});
  for (unsigned i = 0; i < 8; i++)
    if (children >> i & 1U) collect(OcTreeAccess::child(*node, i), depth + 1, parts);
}

/** The distinct values of the leaves, and the place of each leaf's value among them. */
struct ValueTable {
  std::vector<uint32_t> values;  ///< Most frequent first; empty if there are too many
  std::vector<uint32_t> places;  ///< Of each leaf
};

/** Numbers values in the order in which they come. */
class ValueNumbers {
 public:
  /** Returns the number of a value, which is new or known. */
  uint32_t operator[](uint32_t value) {
    size_t slot = (value * 0x9e3779b1U) >> (32U - kSlotBits);
    while (numbers_[slot] != kFree && values_[numbers_[slot]] != value)
      slot = (slot + 1) & (numbers_.size() - 1);
    if (numbers_[slot] == kFree) {
      numbers_[slot] = static_cast<uint32_t>(values_.size());
      values_.push_back(value);
    }
    return numbers_[slot];
  }
  const std::vector<uint32_t>& values() const { return values_; }

 private:
  static constexpr unsigned kSlotBits = 18;
  static constexpr uint32_t kFree = std::numeric_limits<uint32_t>::max();
  static_assert(kMostValues <= (size_t{1} << kSlotBits) / 4, "the table has free slots");

  std::vector<uint32_t> values_;
  std::vector<uint32_t> numbers_ = std::vector<uint32_t>(size_t{1} << kSlotBits, kFree);
};

ValueTable tableOf(const std::vector<uint32_t>& leaves) {
  // If nearly all leaves have distinct values, a table would only add data.
  const uint64_t most = std::min<uint64_t>(kMostValues, leaves.size() / 4 + 1);
  ValueNumbers numbers;
  std::vector<size_t> count;
  ValueTable table;
  table.places.reserve(leaves.size());
  for (const uint32_t value : leaves) {
    const uint32_t number = numbers[value];
    if (number == count.size()) count.push_back(0);
    if (count.size() > most) return {};
    count[number]++;
    table.places.push_back(number);
  }
  const std::vector<uint32_t>& values = numbers.values();
  std::vector<uint32_t> order(values.size()), place(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return count[a] != count[b] ? count[a] > count[b] : values[a] < values[b];
  });
  for (uint32_t i = 0; i < order.size(); i++) {
    place[order[i]] = i;
    table.values.push_back(values[order[i]]);
  }
  for (uint32_t& p : table.places) p = place[p];
  return table;
}

std::string flatten(const Parts& parts) {
  std::string out;
  append(parts.masks.size(), out);
  append(parts.leaves.size(), out);
  append(parts.exceptions.size(), out);
  out += parts.masks;
  for (const auto& e : parts.exceptions) append(e.node, out);
  for (const auto& e : parts.exceptions)
    out.append(reinterpret_cast<const char*>(&e.value), sizeof(e.value));

  const ValueTable table = tableOf(parts.leaves);
  append(table.values.size(), out);
  appendPlanes(table.values, sizeof(float), out);
  if (table.values.empty())
    appendPlanes(parts.leaves, sizeof(float), out);
  else
    appendPlanes(table.places, bytesFor(table.values.size()), out);
  return out;
}

/** The sizes of the parts, at the beginning of the data. */
struct Counts {
  uint64_t masks = 0, leaves = 0, exceptions = 0;

  /** Returns the largest size of data with these counts, bytes. */
  uint64_t mostBytes() const {
    return 4 * sizeof(uint64_t) + masks + (leaves + kMostValues) * sizeof(float) +
           exceptions * (sizeof(uint64_t) + sizeof(float));
  }
};

Counts takeCounts(ByteReader& in, size_t most_nodes) {
  Counts n;
  n.masks = in.take<uint64_t>();
  n.leaves = in.take<uint64_t>();
  n.exceptions = in.take<uint64_t>();
  for (const uint64_t count : {n.masks, n.leaves, n.exceptions})
    if (count > most_nodes) corrupt("the map's data is corrupt: too many nodes");
  return n;
}

/** Builds an octree from its parts. */
class Unflattening {
 public:
  Unflattening(std::string_view bytes, octomap::OcTree& tree, size_t most_nodes) : tree_(tree) {
    ByteReader in(bytes);
    const auto [masks, leaves, exceptions] = takeCounts(in, most_nodes);
    masks_ = in.takeBytes(masks);
    const auto inner = masks - static_cast<uint64_t>(std::count(masks_.begin(), masks_.end(), 0));
    if (inner + leaves > most_nodes) corrupt("the map's data is corrupt: too many nodes");
    if (exceptions > inner) corruptStructure();
    if (in.size() < exceptions * (sizeof(uint64_t) + sizeof(float)))
      corrupt("the map's data is truncated");
    exceptions_.resize(exceptions);
    for (auto& e : exceptions_) e.node = in.take<uint64_t>();
    for (auto& e : exceptions_) e.value = in.take<float>();
    const auto table_size = in.take<uint64_t>();
    if (table_size > kMostValues) corrupt("the map's data is corrupt: its table of values");
    const auto table = takePlanes(in, table_size, sizeof(float));
    leaves_ = takePlanes(in, leaves, table.empty() ? sizeof(float) : bytesFor(table.size()));
    if (!table.empty())
      for (uint32_t& leaf : leaves_) {
        if (leaf >= table.size()) corrupt("the map's data is corrupt: no such value");
        leaf = table[leaf];
      }
    if (in.size() > 0) corruptStructure();
  }

  /** Returns whether there is no node. */
  bool empty() const { return masks_.empty() && leaves_.empty(); }

  /** Builds the nodes below a node. \return Number of nodes, with the node. */
  size_t run(OcTreeNode* node, unsigned depth) {
    if (!empty()) visit(node, depth);
    if (next_mask_ != masks_.size() || next_leaf_ != leaves_.size() ||
        next_exception_ != exceptions_.size())
      corruptStructure();
    return next_node_;
  }

 private:
  [[noreturn]] static void corruptStructure() {
    corrupt("the map's data is corrupt: its nodes do not make a tree");
  }

  void visit(OcTreeNode* node, unsigned depth) {
    const uint64_t number = next_node_++;
    uint8_t children = 0;
    if (depth < OcTreeCube::kMaxDepth) {
      if (next_mask_ == masks_.size()) corruptStructure();
      children = static_cast<uint8_t>(masks_[next_mask_++]);
    }
    if (children == 0) {
      if (next_leaf_ == leaves_.size()) corruptStructure();
      set(node, valueOf(leaves_[next_leaf_++]));
      return;
    }
    const bool is_exception =
        next_exception_ < exceptions_.size() && exceptions_[next_exception_].node == number;
    const size_t exception = next_exception_;
    if (is_exception) next_exception_++;
    for (unsigned i = 0; i < 8; i++)
      if (children >> i & 1U) visit(tree_.createNodeChild(node, i), depth + 1);
    set(node, is_exception ? exceptions_[exception].value : node->getMaxChildLogOdds());
  }

  static void set(OcTreeNode* node, float value) {
    if (!std::isfinite(value)) corrupt("the map's data is corrupt: log-odds that are not finite");
    node->setLogOdds(value);
  }

  octomap::OcTree& tree_;
  std::string_view masks_;
  std::vector<uint32_t> leaves_;
  std::vector<Exception> exceptions_;
  uint64_t next_node_ = 0;
  size_t next_mask_ = 0, next_leaf_ = 0, next_exception_ = 0;
};

std::string unpackedParts(std::string_view bytes, size_t most_nodes) {
  return unpacked(bytes, [&](std::string_view beginning) {
    ByteReader in(beginning);
    return takeCounts(in, most_nodes).mostBytes();
  });
}

}  // namespace

std::string compressNodes(const octomap::OcTree& tree, Packing packing) {
  Parts parts;
  if (tree.getRoot()) collect(tree.getRoot(), 0, parts);
  return packed(flatten(parts), packing);
}

std::string compressNodes(const OcTreeNode& node, unsigned depth, Packing packing) {
  Parts parts;
  collect(&node, depth, parts);
  return packed(flatten(parts), packing);
}

void decompressNodes(std::string_view bytes, octomap::OcTree& tree, size_t most_nodes) {
  const std::string flat = unpackedParts(bytes, most_nodes);
  Unflattening parts(flat, tree, most_nodes);
  parts.run(parts.empty() ? nullptr : OcTreeAccess::createRoot(tree), 0);
}

size_t decompressNodes(std::string_view bytes, octomap::OcTree& tree, OcTreeNode& node,
                       unsigned depth, size_t most_nodes) {
  const std::string flat = unpackedParts(bytes, most_nodes);
  Unflattening parts(flat, tree, most_nodes);
  if (parts.empty()) corrupt("the map's data is corrupt: it has no node");
  return parts.run(&node, depth);
}

}  // namespace mrpt::fusion
