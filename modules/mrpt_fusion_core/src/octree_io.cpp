// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <mrpt/maps/octree_build.h>
#include <mrpt/maps/octree_io.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "byte_reader.h"

namespace mrpt::maps {
namespace {

constexpr std::string_view kOtMagic = "# Octomap OcTree file";
constexpr std::string_view kBtMagic = "# Octomap OcTree binary file";

bool startsWith(std::string_view s, std::string_view prefix) {
  return s.substr(0, prefix.size()) == prefix;
}

void checkDepth(unsigned depth) {
  if (depth > OcTreeCube::kMaxDepth) corrupt("the map's data is corrupt: nodes deeper than 16");
}

/** One node of a `.ot` body and all below it. \return Number of nodes read. */
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

/** The children of one node of a `.bt` body, two bits each: 0 unknown, 1 free, 2 occupied, 3 has
 * children. \return Number of nodes read, this one included. */
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
  // As OctoMap writes them: all eight kinds first, then the subtrees.
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

/** Gives a sink the nodes of a tree, a block at a time: what a large map's file holds is never in
 * memory as a whole. */
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

/** Collects a file of about so many bytes. */
template <class Write>
std::string collected(size_t size, Write&& write) {
  std::string bytes;
  bytes.reserve(size);
  write([&](std::string_view piece) { bytes.append(piece); });
  return bytes;
}

constexpr size_t kNodeBytes = 5;

std::string systemError(const std::string& what) { return what + ": " + std::strerror(errno); }

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

std::string serializeNodes(const octomap::OcTree& tree) {
  return collected(tree.size() * kNodeBytes,
                   [&](const ByteSink& sink) { NodeWriter(tree, sink).writeAll(); });
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

std::string readFileBytes(const std::string& path) {
  struct stat st {};
  if (::stat(path.c_str(), &st) != 0) throw std::runtime_error(systemError("cannot be opened"));
  if (S_ISDIR(st.st_mode)) throw std::runtime_error("is a directory, not a file");
  std::ifstream f(path, std::ios::binary);
  if (!f) throw std::runtime_error(systemError("cannot be opened"));
  std::string bytes;
  bytes.reserve(static_cast<size_t>(st.st_size));  // of a pipe 0
  std::array<char, 1U << 16U> block;
  while (f.read(block.data(), block.size()), f.gcount() > 0)
    bytes.append(block.data(), static_cast<size_t>(f.gcount()));
  if (f.bad()) throw std::runtime_error(systemError("cannot be read"));
  if (bytes.empty()) throw std::runtime_error("is empty");
  return bytes;
}

std::string beginningOf(const std::string& path) {
  struct stat st {};
  if (::stat(path.c_str(), &st) == 0 && !S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode))
    throw std::runtime_error("is a pipe or a device: a map is read from a file");
  std::ifstream f(path, std::ios::binary);
  std::string bytes(64, '\0');
  f.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<size_t>(f.gcount()));
  if (bytes.empty()) readFileBytes(path);  // says why: missing, a directory, empty
  return bytes;
}

void saveOcTree(const octomap::OcTree& tree, const std::string& path) {
  if (std::filesystem::path(path).extension() == ".bt")
    writeFileAtomically(path, toBtFile(tree));
  else
    writeFileAtomically(path, [&](const ByteSink& sink) { writeOt(tree, sink); });
}

void writeFileAtomically(const std::string& path, std::string_view bytes) {
  writeFileAtomically(path, [&](const ByteSink& sink) { sink(bytes); });
}

void writeFileAtomically(const std::string& path,
                         const std::function<void(const ByteSink&)>& write) {
  // Of a link, what it leads to is replaced, if it is there. What has no name, as a pipe behind
  // /dev/stdout, is written to, and so is a device or a pipe: it has no contents to protect, and a
  // rename would replace it by a file.
  std::error_code nameless;
  const std::string named = std::filesystem::canonical(path, nameless).string();
  const std::string& target = nameless ? path : named;
  struct stat st {};
  const bool in_place = ::stat(path.c_str(), &st) == 0 && (nameless || !S_ISREG(st.st_mode));
  std::string name = in_place ? path : target + ".XXXXXX";
  const int fd = in_place ? ::open(name.c_str(), O_WRONLY) : ::mkstemp(name.data());
  const auto check = [&](bool done) {
    if (!done) throw std::runtime_error(systemError(path + ": cannot be written"));
  };
  check(fd >= 0);
  try {
    write([&](std::string_view bytes) {
      while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        check(n >= 0 || errno == EINTR);
        if (n > 0) bytes.remove_prefix(static_cast<size_t>(n));
      }
    });
    if (!in_place) {
      // mkstemp() makes the file private; give it the rights any new file would have.
      const mode_t mask = ::umask(0);
      ::umask(mask);
      check(::fchmod(fd, 0666 & ~mask) == 0 && ::fsync(fd) == 0 &&
            ::rename(name.c_str(), target.c_str()) == 0);
    }
  } catch (...) {
    ::close(fd);
    if (!in_place) ::unlink(name.c_str());
    throw;
  }
  ::close(fd);
}

}  // namespace mrpt::maps
