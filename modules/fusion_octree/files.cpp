// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads and writes `.ot` and `.bt` files. */
#include "fusion_octree/files.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "fusion_base/byte_reader.h"
#include "fusion_base/files.h"
#include "fusion_octree/build.h"

namespace mrpt::fusion {
namespace {

constexpr std::string_view kOtMagic = "# Octomap OcTree file";
constexpr std::string_view kBtMagic = "# Octomap OcTree binary file";

bool startsWith(std::string_view s, std::string_view prefix) {
  return s.substr(0, prefix.size()) == prefix;
}

void checkDepth(unsigned depth) {
  if (depth > OcTreeCube::kMaxDepth) corrupt("the map's data is corrupt: nodes deeper than 16");
}

/** Reads a node of a `.ot` body and all nodes below it. \return Number of nodes read. */
size_t readNode(ByteReader& in, octomap::OcTree& tree, octomap::OcTreeNode* node, unsigned depth,
                size_t extra_bytes) {
  checkDepth(depth);
  const auto log_odds = in.take<float>();
  if (!std::isfinite(log_odds)) corrupt("the map's data is corrupt: log-odds that are not finite");
  node->setLogOdds(log_odds);
  in.takeBytes(extra_bytes);
  const auto children = in.take<uint8_t>();
  size_t count = 1;
  for (unsigned i = 0; i < 8; i++)
    if ((children >> i) & 1U)
      count += readNode(in, tree, tree.createNodeChild(node, i), depth + 1, extra_bytes);
  return count;
}

/** Reads the children of a node of a `.bt` body. Each has 2 bits: 0 unknown, 1 free, 2 occupied, 3
 * has children. \return Number of nodes read, including this node. */
size_t readBinaryNode(ByteReader& in, octomap::OcTree& tree, octomap::OcTreeNode* node,
                      unsigned depth) {
  const auto children = in.take<uint16_t>();
  if (children) checkDepth(depth + 1);
  size_t count = 1;
  for (unsigned i = 0; i < 8; i++) {
    const unsigned kind = (children >> (2 * i)) & 3U;
    if (!kind) continue;
    auto* child = tree.createNodeChild(node, i);
    if (kind != 3) {
      child->setLogOdds(kind == 2 ? tree.getClampingThresMaxLog() : tree.getClampingThresMinLog());
      count++;
    }
  }
  // OctoMap's order: first all 8 kinds, then the subtrees.
  for (unsigned i = 0; i < 8; i++)
    if (((children >> (2 * i)) & 3U) == 3)
      count += readBinaryNode(in, tree, tree.getNodeChild(node, i), depth + 1);
  if (children)
    node->updateOccupancyChildren();
  else
    corrupt("the map's data is corrupt: an inner node without children");
  return count;
}

struct Header {
  std::string id;
  size_t size = 0;
  double resolution = 0;
  std::string_view data;
};

Header parseHeader(std::string_view bytes) {
  Header h;
  bool has_size = false;
  while (true) {
    const size_t eol = bytes.find('\n');
    if (eol == std::string_view::npos) corrupt("the header ends before its 'data' line");
    std::istringstream line(std::string(bytes.substr(0, std::min(eol, size_t{256}))));
    bytes.remove_prefix(eol + 1);
    std::string word;
    line >> word;
    if (word == "data") break;
    if (word == "id")
      line >> h.id;
    else if (word == "size")
      has_size = static_cast<bool>(line >> h.size);
    else if (word == "res" && !(line >> h.resolution))
      h.resolution = 0;
  }
  if (h.id.empty()) corrupt("the header has no 'id'");
  if (!has_size) corrupt("the header has no valid 'size'");
  if (!(h.resolution > 0) || !std::isfinite(h.resolution))
    corrupt("the header has no valid 'res' (voxel size in metres)");
  h.data = bytes;
  return h;
}

/** Writes the nodes of an octree to a sink, in blocks: the file of a large map is never in memory
 * as a whole. */
class NodeWriter {
 public:
  NodeWriter(const octomap::OcTree& tree, const ByteSink& sink) : tree_(tree), sink_(sink) {}

  void writeAll() {
    if (!tree_.getRoot()) return;
    write(*tree_.getRoot());
    flush();
  }

 private:
  void write(const octomap::OcTreeNode& node) {
    const float log_odds = node.getLogOdds();
    uint8_t children = 0;
    for (unsigned i = 0; i < 8; i++)
      if (tree_.nodeChildExists(&node, i)) children |= static_cast<uint8_t>(1U << i);
    if (block_.size() - used_ < sizeof(log_odds) + sizeof(children)) flush();
    std::memcpy(&block_[used_], &log_odds, sizeof(log_odds));
    used_ += sizeof(log_odds);
    block_[used_++] = static_cast<char>(children);
    if (!children) return;
    for (unsigned i = 0; i < 8; i++)
      if ((children >> i) & 1U) write(*tree_.getNodeChild(&node, i));
  }
  void flush() {
    sink_({block_.data(), used_});
    used_ = 0;
  }

  const octomap::OcTree& tree_;
  const ByteSink& sink_;
  std::array<char, 1U << 16U> block_;
  size_t used_ = 0;
};

/** Collects a file of about \a size bytes. */
template <class Write>
std::string collected(size_t size, Write&& write) {
  std::string bytes;
  bytes.reserve(size);
  write([&](std::string_view piece) { bytes.append(piece); });
  return bytes;
}

constexpr size_t kNodeBytes = 5;

std::string otHeader(const octomap::OcTree& tree) {
  char resolution[32] = {};  // shortest text that reads back to the same double
  std::to_chars(resolution, std::end(resolution), tree.getResolution());
  std::ostringstream header;
  header << kOtMagic
         << "\n# (feel free to add / change comments, but leave the first line as it is!)"
         << "\n#\nid OcTree\nsize " << tree.size() << "\nres " << resolution << "\ndata\n";
  return header.str();
}

void writeOt(const octomap::OcTree& tree, const ByteSink& sink) {
  sink(otHeader(tree));
  NodeWriter(tree, sink).writeAll();
}

}  // namespace

bool isOcTreeFile(std::string_view bytes) {
  return startsWith(bytes, kOtMagic) || startsWith(bytes, kBtMagic);
}

size_t parseNodes(std::string_view bytes, octomap::OcTree& tree, size_t extra_bytes_per_node) {
  if (bytes.empty()) return 0;
  ByteReader in(bytes);
  return readNode(in, tree, OcTreeAccess::createRoot(tree), 0, extra_bytes_per_node);
}

std::unique_ptr<octomap::OcTree> parseOcTreeFile(std::string_view bytes) {
  const bool binary = startsWith(bytes, kBtMagic);
  if (!binary && !startsWith(bytes, kOtMagic)) corrupt("not an OctoMap file (.ot or .bt)");

  const Header h = parseHeader(bytes);
  const bool colour = !binary && h.id == "ColorOcTree";
  if (h.id != "OcTree" && !colour) corrupt("trees of type '" + h.id + "' are not supported");

  auto tree = std::make_unique<octomap::OcTree>(h.resolution);
  size_t count = 0;
  if (h.size > 0) {
    if (binary) {
      ByteReader in(h.data);
      count = readBinaryNode(in, *tree, OcTreeAccess::createRoot(*tree), 0);
    } else {
      count = parseNodes(h.data, *tree, colour ? 3 : 0);
    }
  }
  if (count != h.size)
    corrupt("the header announces " + std::to_string(h.size) + " nodes, the data holds " +
            std::to_string(count));
  return tree;
}

void serializeNodes(const octomap::OcTree& tree, const ByteSink& sink) {
  NodeWriter(tree, sink).writeAll();
}

std::string serializeNodes(const octomap::OcTree& tree) {
  return collected(tree.size() * kNodeBytes,
                   [&](const ByteSink& sink) { serializeNodes(tree, sink); });
}

std::string toOtFile(const octomap::OcTree& tree) {
  constexpr size_t kHeader = 200;
  return collected(kHeader + tree.size() * kNodeBytes,
                   [&](const ByteSink& sink) { writeOt(tree, sink); });
}

std::string toBtFile(const octomap::OcTree& tree) {
  octomap::OcTree copy(tree);
  std::ostringstream out;
  out.precision(17);
  copy.writeBinary(out);
  return out.str();
}

void saveOcTree(const octomap::OcTree& tree, const std::string& path) {
  if (std::filesystem::path(path).extension() == ".bt")
    writeFileAtomically(path, toBtFile(tree));
  else
    writeFileAtomically(path, [&](const ByteSink& sink) { writeOt(tree, sink); });
}

}  // namespace mrpt::fusion
