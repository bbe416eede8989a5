// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads and writes `.ot` and `.bt` files. */
#include "fusion_octree/files.h"

#include <array>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "fusion_base/byte_reader.h"
#include "fusion_base/files.h"
#include "fusion_base/gzip.h"
#include "fusion_base/printable.h"
#include "fusion_octree/file_budget.h"
#include "fusion_octree/file_header.h"
#include "fusion_octree/node_reader.h"
#include "fusion_octree/resolution.h"

namespace mrpt::fusion {
namespace {

/** Returns the layout of the nodes. \exception std::runtime_error If it is not known. */
NodeLayout layoutOf(const OcTreeHeader& h) {
  if (h.format != OcTreeFormat::Ot) return NodeLayout::Kinds;
  if (h.id == "ColorOcTree") return NodeLayout::LogOddsAndColour;
  if (h.id == "OcTree" || h.id == "OcTreeStamped") return NodeLayout::LogOdds;
  constexpr size_t kMostCharacters = 40;
  corrupt("trees of type '" + printable(h.id, kMostCharacters) + "' are not supported");
}

/** What parseOcTreeFile() says about a map. */
class Notes {
 public:
  explicit Notes(std::vector<std::string>* notes) : notes_(notes) {}
  void add(const std::string& note) {
    if (notes_) notes_->push_back(note);
  }
  void addOn(const NodeReader& reader) {
    if (reader.hasClamped()) add("infinite log-odds were clamped to OctoMap's thresholds");
    if (reader.hasColours()) add("colours are not kept: the map is used without colours");
  }

 private:
  std::vector<std::string>* notes_;
};

std::unique_ptr<octomap::OcTree> parsePlainFile(std::string_view bytes, size_t most_memory,
                                                Notes& notes) {
  const OcTreeHeader h = parseOcTreeHeader(bytes);
  const NodeLayout layout = layoutOf(h);
  auto tree = std::make_unique<octomap::OcTree>(h.resolution);
  if (h.size == 0) return tree;
  NodeReader reader(h.data, *tree, NodeReader::Infinities::Clamp, most_memory);
  const size_t count = reader.read(layout);
  notes.addOn(reader);
  if (count != h.size && reader.bytesLeft() > 0)
    throw std::runtime_error("is damaged: the header announces " + std::to_string(h.size) +
                             " nodes, the data holds " + std::to_string(count) + " and more bytes");
  if (count != h.size)
    notes.add("the header announces " + std::to_string(h.size) + " nodes, the data holds " +
              std::to_string(count) + ": all nodes of the data are used");
  return tree;
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
constexpr std::string_view kComment =
    "\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n";

std::string otHeader(const octomap::OcTree& tree) {
  char resolution[32] = {};  // shortest text that reads back to the same double
  std::to_chars(resolution, std::end(resolution), tree.getResolution());
  std::ostringstream header;
  header << kOtMagic << kComment << "id OcTree\nsize " << tree.size() << "\nres " << resolution
         << "\ndata\n";
  return header.str();
}

void writeOt(const octomap::OcTree& tree, const ByteSink& sink) {
  sink(otHeader(tree));
  NodeWriter(tree, sink).writeAll();
}

}  // namespace

bool isOcTreeFile(std::string_view bytes) { return ocTreeFormatOf(bytes).has_value(); }

size_t parseNodes(std::string_view bytes, octomap::OcTree& tree) {
  if (bytes.empty()) return 0;
  return NodeReader(bytes, tree, NodeReader::Infinities::Reject).read(NodeLayout::LogOdds);
}

std::unique_ptr<octomap::OcTree> parseOcTreeFile(std::string_view bytes,
                                                 std::vector<std::string>* notes) {
  const FileBudget budget = FileBudget::of(bytes.size());
  Notes to(notes);
  if (!isGzip(bytes)) return parsePlainFile(bytes, budget.memory, to);
  return parsePlainFile(gunzipped(bytes, budget.bytes), budget.memory, to);
}

std::unique_ptr<octomap::OcTree> parseRawOcTree(std::string_view bytes, double resolution,
                                                std::vector<std::string>* notes) {
  checkResolution(resolution);
  const FileBudget budget = FileBudget::of(bytes.size());
  const std::string unpacked = isGzip(bytes) ? gunzipped(bytes, budget.bytes) : std::string();
  const std::string_view nodes = isGzip(bytes) ? unpacked : bytes;
  for (const auto layout : {NodeLayout::LogOdds, NodeLayout::LogOddsAndColour, NodeLayout::Kinds}) {
    auto tree = std::make_unique<octomap::OcTree>(resolution);
    NodeReader reader(nodes, *tree, NodeReader::Infinities::Clamp, budget.memory);
    try {
      reader.read(layout);
    } catch (const std::runtime_error&) {
      continue;  // another layout
    }
    if (reader.bytesLeft() > 0) continue;
    Notes(notes).addOn(reader);
    return tree;
  }
  return nullptr;
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
  copy.toMaxLikelihood();
  copy.prune();
  std::ostringstream out;  // not by OctoMap's writeBinary(), which prints to stderr
  constexpr int kDigits = 17;
  out.precision(kDigits);
  out << kBtMagic << kComment << "id OcTree\nsize " << copy.size() << "\nres "
      << copy.getResolution() << "\ndata\n";
  if (copy.getRoot()) copy.writeBinaryData(out);
  return out.str();
}

void saveOcTree(const octomap::OcTree& tree, const std::string& path) {
  if (std::filesystem::path(path).extension() == ".bt")
    writeFileAtomically(path, toBtFile(tree));
  else
    writeFileAtomically(path, [&](const ByteSink& sink) { writeOt(tree, sink); });
}

}  // namespace mrpt::fusion
