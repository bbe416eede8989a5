// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the kinds of files that OctoMap reads: each is read by OctoMap and by us. */
#include <octomap/ColorOcTree.h>
#include <octomap/OcTreeStamped.h>

#include <limits>
#include <sstream>

#include "support/gzip_bytes.h"
#include "support/tree_tools.h"

using namespace map_tests;
using mrpt::fusion::isOcTreeFile;
using mrpt::fusion::parseOcTreeFile;
using mrpt::fusion::parseRawOcTree;
using octomap::OcTree;

namespace {

/** Fills an octree of any type with the same values. */
template <class Tree>
Tree filled(double resolution = 0.1) {
  Tree tree(resolution);
  std::mt19937 rng(7);
  std::uniform_int_distribution<int> place(-40, 40);
  std::uniform_real_distribution<float> value(-1.9F, 3.4F);
  for (int i = 0; i < 500; i++)
    tree.setNodeValue(keyOf({place(rng), place(rng), place(rng)}), value(rng));
  return tree;
}

octomap::ColorOcTree coloured() {
  auto tree = filled<octomap::ColorOcTree>();
  uint8_t i = 0;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it) it->setColor(i++, 200, 7);
  return tree;
}

template <class Tree>
std::string otOf(const Tree& tree) {
  std::ostringstream out;
  out.precision(17);
  tree.write(out);
  return out.str();
}

template <class Tree>
std::string btOf(Tree tree) {
  std::ostringstream out;
  out.precision(17);
  tree.writeBinary(out);
  return out.str();
}

/** Returns the leaves of an octree of any type. */
template <class Tree>
std::vector<NodeRecord> leavesOfAny(const Tree& tree) {
  std::vector<NodeRecord> nodes;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it) {
    const auto k = it.getKey();
    nodes.push_back({{k[0], k[1], k[2]}, it.getDepth(), true, bitsOf(it->getLogOdds())});
  }
  return nodes;
}

/** Reads a `.ot` file with OctoMap, and compares leaf by leaf. */
template <class Tree>
void expectOtAsOctomap(const std::string& bytes, const std::string& plain) {
  std::istringstream in(bytes);
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(in));
  const auto* theirs = dynamic_cast<const Tree*>(read.get());
  ASSERT_TRUE(theirs);
  ASSERT_GT(theirs->size(), 500U);
  const auto ours = parseOcTreeFile(plain);
  EXPECT_EQ(theirs->getResolution(), ours->getResolution());
  EXPECT_EQ(theirs->size(), ours->size());
  EXPECT_TRUE(sameNodes(leavesOfAny(*theirs), leavesOf(*ours)));
}
template <class Tree>
void expectOtAsOctomap(const std::string& bytes) {
  expectOtAsOctomap<Tree>(bytes, bytes);
}

/** Reads a `.bt` file with OctoMap, and compares leaf by leaf. OctoMap reads all nodes even if it
 * returns false for a wrong number of nodes. */
void expectBtAsOctomap(const std::string& bytes, const std::string& plain,
                       bool is_refused = false) {
  OcTree theirs(1.0);
  std::istringstream in(bytes);
  EXPECT_EQ(!is_refused, theirs.readBinary(in));
  ASSERT_GT(theirs.size(), 500U);
  EXPECT_TRUE(sameTree(theirs, *parseOcTreeFile(plain)));
}
void expectBtAsOctomap(const std::string& bytes) { expectBtAsOctomap(bytes, bytes); }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(std::string::npos, at) << from;
  return text.replace(at, from.size(), to);
}

/** Returns the header line of a keyword without its value, and the value. */
std::string withSize(const std::string& bytes, const std::string& size) {
  const size_t at = bytes.find("size ") + 5;
  return bytes.substr(0, at) + size + bytes.substr(bytes.find('\n', at));
}

std::string dataOf(const std::string& bytes) { return bytes.substr(bytes.find("data\n") + 5); }

std::vector<std::string> notesOf(const std::string& bytes) {
  std::vector<std::string> notes;
  parseOcTreeFile(bytes, &notes);
  return notes;
}

/** The 16 bytes before the nodes of a file of 2010. */
std::string legacyHeader(double resolution, uint32_t size) {
  const int32_t type = 3;
  std::string bytes(reinterpret_cast<const char*>(&type), sizeof(type));
  bytes.append(reinterpret_cast<const char*>(&resolution), sizeof(resolution));
  return bytes.append(reinterpret_cast<const char*>(&size), sizeof(size));
}

}  // namespace

TEST(OctomapKinds, AColouredTreeIsReadWithoutItsColours) {
  const auto tree = coloured();
  expectOtAsOctomap<octomap::ColorOcTree>(otOf(tree));
  expectBtAsOctomap(btOf(tree));
  ASSERT_EQ(1U, notesOf(otOf(tree)).size());
  EXPECT_NE(std::string::npos, notesOf(otOf(tree)).front().find("colours are not kept"));
  EXPECT_TRUE(notesOf(btOf(tree)).empty()) << "the file has no colours";
  EXPECT_TRUE(notesOf(otOf(filled<octomap::ColorOcTree>())).empty()) << "no node has a colour";
}

TEST(OctomapKinds, AStampedTreeIsReadAsAPlainTree) {
  const auto tree = filled<octomap::OcTreeStamped>();
  expectOtAsOctomap<octomap::OcTreeStamped>(otOf(tree));
  expectBtAsOctomap(btOf(tree));
  EXPECT_TRUE(notesOf(otOf(tree)).empty()) << "files have no time stamps";
}

TEST(OctomapKinds, AWrongNumberOfNodesIsNoted) {
  const auto tree = filled<OcTree>();
  for (const std::string size : {"1", "42", "4000000000", "-1"}) {
    const std::string ot = withSize(otOf(tree), size), bt = withSize(btOf(tree), size);
    expectOtAsOctomap<OcTree>(ot);
    const bool is_refused = true;
    expectBtAsOctomap(bt, bt, is_refused);
    for (const auto& bytes : {ot, bt}) {
      ASSERT_EQ(1U, notesOf(bytes).size()) << size;
      EXPECT_NE(std::string::npos, notesOf(bytes).front().find("nodes")) << size;
    }
  }
  EXPECT_TRUE(notesOf(otOf(tree)).empty());
}

TEST(OctomapKinds, AWrongNumberOfNodesWithBytesLeftIsDamage) {
  const auto tree = filled<OcTree>();
  for (const std::string& bytes : {otOf(tree), btOf(tree)})
    EXPECT_NE(errorOf([&] { parseOcTreeFile(withSize(bytes, "42") + "more"); }).find("damaged"),
              std::string::npos);
}

TEST(OctomapKinds, ZeroNodesAreAnEmptyMap) {
  const std::string bytes = withSize(otOf(filled<OcTree>()), "0");
  std::istringstream in(bytes);
  const std::unique_ptr<octomap::AbstractOcTree> theirs(octomap::AbstractOcTree::read(in));
  ASSERT_TRUE(theirs);
  EXPECT_EQ(theirs->size(), parseOcTreeFile(bytes)->size());
}

TEST(OctomapKinds, AHeaderMayBeOnOneLine) {
  const std::string ot = otOf(filled<OcTree>());
  const size_t data = ot.find("data\n");
  const std::string size = std::to_string(filled<OcTree>().size());
  const std::string line = "# Octomap OcTree file\nid OcTree size " + size + " res 0.1 ";
  expectOtAsOctomap<OcTree>(line + "\n" + ot.substr(data));
  expectOtAsOctomap<OcTree>(line + ot.substr(data));
  expectOtAsOctomap<OcTree>(replaced(ot, "\nsize ", "\r\n\tframe map\r\n  size\t"));
}

TEST(OctomapKinds, TheOldIdOfATreeIsRead) {
  expectOtAsOctomap<OcTree>(replaced(otOf(filled<OcTree>()), "id OcTree", "id 1"));
  expectBtAsOctomap(replaced(btOf(filled<OcTree>()), "id OcTree", "id 1"));
}

TEST(OctomapKinds, TheBinaryHeaderOf2010IsRead) {
  OcTree tree = filled<OcTree>(0.08);
  tree.toMaxLikelihood();
  tree.prune();
  const std::string data = dataOf(btOf(tree));
  const std::string bytes = legacyHeader(0.08, static_cast<uint32_t>(tree.size())) + data;
  EXPECT_TRUE(isOcTreeFile(bytes));
  expectBtAsOctomap(bytes);
  EXPECT_TRUE(notesOf(bytes).empty());
  for (const double resolution : {0.0, -1.0, 1e38, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_FALSE(isOcTreeFile(legacyHeader(resolution, 5) + data)) << resolution;
  for (size_t n = 0; n < bytes.size(); n += 7)
    EXPECT_THROW(parseOcTreeFile(bytes.substr(0, n)), std::runtime_error) << n;
}

TEST(OctomapKinds, InfiniteLogOddsBecomeTheThresholds) {
  OcTree tree = filled<OcTree>();
  OcTree expected = filled<OcTree>();
  const auto other = [&](float v) {
    const float infinity = std::numeric_limits<float>::infinity();
    return v > 2 ? infinity : v < -1 ? -infinity : v;
  };
  for (auto it = tree.begin_tree(); it != tree.end_tree(); ++it)
    it->setLogOdds(other(it->getLogOdds()));
  for (auto it = expected.begin_tree(); it != expected.end_tree(); ++it) {
    const float v = it->getLogOdds();
    it->setLogOdds(v > 2    ? expected.getClampingThresMaxLog()
                   : v < -1 ? expected.getClampingThresMinLog()
                            : v);
  }
  EXPECT_TRUE(sameTree(expected, *parseOcTreeFile(otOf(tree))));
  ASSERT_EQ(1U, notesOf(otOf(tree)).size());
  EXPECT_NE(std::string::npos, notesOf(otOf(tree)).front().find("infinite log-odds were clamped"));
}

TEST(OctomapKinds, EachMayBeGzipped) {
  const std::string ot = otOf(filled<OcTree>()), bt = btOf(filled<OcTree>());
  expectOtAsOctomap<OcTree>(ot, gzipped(ot));
  expectOtAsOctomap<octomap::ColorOcTree>(otOf(coloured()), gzipped(otOf(coloured())));
  expectBtAsOctomap(bt, gzipped(bt));
  // Packed in two parts, as by `gzip >> file`, and with bytes after the packed data.
  expectBtAsOctomap(bt, gzipped(bt.substr(0, 100)) + gzipped(bt.substr(100)) + "garbage");
}

TEST(OctomapKinds, DamagedGzipIsAnError) {
  const std::string packed = gzipped(otOf(filled<OcTree>()));
  for (size_t n = 2; n < packed.size(); n += 5)
    EXPECT_THROW(parseOcTreeFile(packed.substr(0, n)), std::runtime_error) << n;
  std::string damaged = packed;
  damaged[damaged.size() / 2] ^= 0x55;
  EXPECT_THROW(parseOcTreeFile(damaged), std::runtime_error);
  EXPECT_THROW(parseOcTreeFile(gzipped("no map")), std::runtime_error);
}

TEST(OctomapKinds, GzipThatUnpacksToTooMuchIsAnError) {
  const std::string zeros = gzipped(otOf(filled<OcTree>()) + std::string(size_t{200} << 20U, '\0'));
  ASSERT_LT(zeros.size(), 300'000U);
  const std::string error = errorOf([&] { parseOcTreeFile(zeros); });
  EXPECT_NE(std::string::npos, error.find("unpacks to more than")) << error;
}

TEST(OctomapKinds, GzipOfTooManyNodesIsAnError) {
  // 8 full octrees of 6 levels, and below each of their leaves a chain, whose nodes need most
  // memory.
  const auto node = [](uint8_t children) {
    return std::string(4, '\0') + static_cast<char>(children);
  };
  std::string full = node(1) + node(1) + node(1) + node(0);
  for (int level = 0; level < 6; level++) {
    std::string larger = node(0xFF);
    for (int i = 0; i < 8; i++) larger += full;
    full = larger;
  }
  std::string bytes = "# Octomap OcTree file\nid OcTree\nsize 1\nres 0.1\ndata\n" + node(0xFF);
  for (int i = 0; i < 8; i++) bytes += full;
  const std::string packed = gzipped(bytes);
  ASSERT_LT(packed.size(), 500'000U);
  const std::string error = errorOf([&] { parseOcTreeFile(packed); });
  EXPECT_NE(std::string::npos, error.find("too much memory")) << error;
}

TEST(OctomapKinds, TheDataOfAMessageIsReadWithAResolution) {
  const auto plain = filled<OcTree>();
  const auto colours = coloured();
  OcTree likely = plain;
  likely.toMaxLikelihood();
  likely.prune();
  const std::string full = dataOf(otOf(plain)), binary = dataOf(btOf(plain));
  EXPECT_TRUE(sameTree(plain, *parseRawOcTree(full, 0.1)));
  EXPECT_TRUE(sameNodes(leavesOf(likely), leavesOf(*parseRawOcTree(binary, 0.1))));
  EXPECT_TRUE(sameNodes(leavesOf(plain), leavesOf(*parseRawOcTree(gzipped(full), 0.1))));
  std::vector<std::string> notes;
  EXPECT_TRUE(sameNodes(leavesOfAny(colours),
                        leavesOf(*parseRawOcTree(dataOf(otOf(colours)), 0.1, &notes))));
  EXPECT_EQ(1U, notes.size());
  EXPECT_EQ(nullptr, parseRawOcTree(full.substr(1), 0.1));
  EXPECT_EQ(nullptr, parseRawOcTree(full + "x", 0.1));
  EXPECT_EQ(nullptr, parseRawOcTree("These are words, not nodes.", 0.1));
  for (const double resolution : {0.0, 1e-5, 1e7, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(parseRawOcTree(full, resolution), std::runtime_error) << resolution;
}
