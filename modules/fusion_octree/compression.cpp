// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Compresses octrees with LZMA, and reads untrusted compressed data. */
#include "fusion_octree/compression.h"

#include <lzma.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <unordered_map>
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

uint8_t childrenOf(const octomap::OcTree& tree, const OcTreeNode* node) {
  uint8_t children = 0;
  for (unsigned i = 0; i < 8; i++)
    if (tree.nodeChildExists(node, i)) children |= static_cast<uint8_t>(1U << i);
  return children;
}

/** Appends \a bytes planes: plane i holds byte i of each number. */
void appendPlanes(const std::vector<uint32_t>& numbers, unsigned bytes, std::string& out) {
  for (unsigned i = 0; i < bytes; i++)
    for (const uint32_t n : numbers) out.push_back(static_cast<char>(n >> (8 * i) & 0xFFU));
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

void collect(const octomap::OcTree& tree, const OcTreeNode* node, unsigned depth, Parts& parts) {
  const uint64_t number = parts.nodes++;
  if (number >= kMostCompressedNodes) throw std::length_error("the map is too large to compress");
  const uint8_t children = childrenOf(tree, node);
  if (depth < OcTreeCube::kMaxDepth) parts.masks.push_back(static_cast<char>(children));
  if (children == 0) {
    parts.leaves.push_back(bitsOf(node->getLogOdds()));
    return;
  }
  if (bitsOf(node->getLogOdds()) != bitsOf(node->getMaxChildLogOdds()))
    parts.exceptions.push_back({number, node->getLogOdds()});
  for (unsigned i = 0; i < 8; i++)
    if (children >> i & 1U) collect(tree, tree.getNodeChild(node, i), depth + 1, parts);
}

/** Returns the distinct values, most frequent first. */
std::vector<uint32_t> tableOf(const std::vector<uint32_t>& leaves) {
  std::unordered_map<uint32_t, size_t> count;
  for (const uint32_t value : leaves) count[value]++;
  std::vector<uint32_t> table;
  table.reserve(count.size());
  for (const auto& [value, n] : count) table.push_back(value);
  std::sort(table.begin(), table.end(), [&](uint32_t a, uint32_t b) {
    return count[a] != count[b] ? count[a] > count[b] : a < b;
  });
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

  // If nearly all leaves have distinct values, a table would only add data.
  std::vector<uint32_t> table = tableOf(parts.leaves);
  if (table.size() > kMostValues || table.size() > parts.leaves.size() / 4 + 1) table.clear();
  append(table.size(), out);
  appendPlanes(table, sizeof(float), out);
  if (table.empty()) {
    appendPlanes(parts.leaves, sizeof(float), out);
    return out;
  }
  std::unordered_map<uint32_t, uint32_t> place;
  for (uint32_t i = 0; i < table.size(); i++) place[table[i]] = i;
  std::vector<uint32_t> places(parts.leaves.size());
  std::transform(parts.leaves.begin(), parts.leaves.end(), places.begin(),
                 [&](uint32_t value) { return place[value]; });
  appendPlanes(places, bytesFor(table.size()), out);
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

  void run() {
    if (!masks_.empty()) visit(OcTreeAccess::createRoot(tree_), 0);
    if (next_mask_ != masks_.size() || next_leaf_ != leaves_.size() ||
        next_exception_ != exceptions_.size())
      corruptStructure();
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

std::string compressed(std::string_view bytes) {
  lzma_options_lzma options;
  lzma_lzma_preset(&options, 9 | LZMA_PRESET_EXTREME);
  constexpr size_t kSmallest = LZMA_DICT_SIZE_MIN, kLargest = size_t{1} << 26U;
  options.dict_size = static_cast<uint32_t>(std::clamp(bytes.size(), kSmallest, kLargest));
  options.pb = 0;  // bytes have no alignment
  lzma_filter filters[] = {{LZMA_FILTER_LZMA2, &options}, {LZMA_VLI_UNKNOWN, nullptr}};
  std::string out(lzma_stream_buffer_bound(bytes.size()), '\0');
  size_t size = 0;
  if (::lzma_stream_buffer_encode(
          filters, LZMA_CHECK_CRC32, nullptr, reinterpret_cast<const uint8_t*>(bytes.data()),
          bytes.size(), reinterpret_cast<uint8_t*>(out.data()), &size, out.size()) != LZMA_OK)
    throw std::bad_alloc();
  out.resize(size);
  return out;
}

std::string decompressed(std::string_view bytes, size_t most_nodes) {
  constexpr uint64_t kMemory = uint64_t{1} << 28U;
  uint64_t most = std::numeric_limits<uint64_t>::max();  // known from the first block on
  lzma_stream stream = LZMA_STREAM_INIT;
  const std::unique_ptr<lzma_stream, decltype(&::lzma_end)> end(&stream, &::lzma_end);
  if (::lzma_stream_decoder(&stream, kMemory, 0) != LZMA_OK) throw std::bad_alloc();
  stream.next_in = reinterpret_cast<const uint8_t*>(bytes.data());
  stream.avail_in = bytes.size();
  std::string out;
  std::vector<uint8_t> block(size_t{1} << 18U);
  lzma_ret state = LZMA_OK;
  while (state == LZMA_OK && out.size() <= most) {
    stream.next_out = block.data();
    stream.avail_out = block.size();
    state = ::lzma_code(&stream, LZMA_FINISH);
    const bool is_first = out.empty();
    out.append(block.begin(), block.end() - static_cast<ptrdiff_t>(stream.avail_out));
    if (is_first && out.size() == block.size()) {
      ByteReader in(out);
      most = takeCounts(in, most_nodes).mostBytes();
    }
  }
  const bool all_taken = stream.avail_in == 0;
  if (state != LZMA_STREAM_END || !all_taken)
    corrupt("the map's compressed data is truncated or damaged");
  return out;
}

}  // namespace

std::string compressNodes(const octomap::OcTree& tree) {
  Parts parts;
  if (tree.getRoot()) collect(tree, tree.getRoot(), 0, parts);
  return compressed(flatten(parts));
}

void decompressNodes(std::string_view bytes, octomap::OcTree& tree, size_t most_nodes) {
  const std::string flat = decompressed(bytes, most_nodes);
  Unflattening(flat, tree, most_nodes).run();
}

}  // namespace mrpt::fusion
