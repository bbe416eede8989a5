// SPDX-License-Identifier: BSD-3-Clause
#include <octomap/ColorOcTree.h>

#include <limits>
#include <sstream>

#include "support/tree_tools.h"

using namespace map_tests;
using mrpt::fusion::parseNodes;
using mrpt::fusion::parseOcTreeFile;
using mrpt::fusion::readFileBytes;
using mrpt::fusion::serializeNodes;
using mrpt::fusion::toBtFile;
using mrpt::fusion::toOtFile;
using octomap::OcTree;

namespace {

std::unique_ptr<OcTree> readByOctomap(const std::string& ot_bytes) {
  std::istringstream in(ot_bytes);
  std::unique_ptr<octomap::AbstractOcTree> tree(octomap::AbstractOcTree::read(in));
  return std::unique_ptr<OcTree>(dynamic_cast<OcTree*>(tree.release()));
}

std::string writtenByOctomap(const octomap::AbstractOcTree& tree) {
  std::ostringstream out;
  out.precision(17);
  tree.write(out);
  return out.str();
}

std::string btWrittenByOctomap(const OcTree& tree) {
  OcTree copy(tree);  // writeBinary() alters it
  std::ostringstream out;
  out.precision(17);
  copy.writeBinary(out);
  return out.str();
}

const std::string kOtLine = "# Octomap OcTree file\n";
const std::string kBtLine = "# Octomap OcTree binary file\n";

std::string otHeader(const std::string& size, const std::string& resolution = "0.1") {
  return kOtLine + "id OcTree\nsize " + size + "\nres " + resolution + "\ndata\n";
}

std::string otNode(float log_odds, uint8_t children) {
  std::string bytes(reinterpret_cast<const char*>(&log_odds), sizeof(log_odds));
  return bytes + static_cast<char>(children);
}

/** A root with one descendant at each level down to \a depth. */
std::string chainOfNodes(unsigned depth) {
  std::string bytes = otHeader(std::to_string(depth + 1));
  for (unsigned d = 0; d <= depth; d++) bytes += otNode(1, d < depth ? 1 : 0);
  return bytes;
}

std::string btChainOfNodes(unsigned depth) {
  std::string bytes =
      kBtLine + "id OcTree\nsize " + std::to_string(depth + 1) + "\nres 0.1\ndata\n";
  for (unsigned d = 0; d < depth; d++) {
    bytes += static_cast<char>(d + 1 < depth ? 3 : 2);  // child 0: has children, or occupied
    bytes += '\0';
  }
  return bytes;
}

/** Either a whole tree comes out or a std::runtime_error; any other exception ends the test. */
void expectTreeOrError(const std::string& bytes) {
  try {
    const auto tree = parseOcTreeFile(bytes);
    size_t count = 0;
    for (auto it = tree->begin_tree(); it != tree->end_tree(); ++it, ++count)
      ASSERT_TRUE(std::isfinite(it->getLogOdds()));
    ASSERT_EQ(count, tree->size());
  } catch (const std::runtime_error&) {
  }
}

}  // namespace

// ---------------------------------------------------------------- .ot

class OctreeIoResolution : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Awkward, OctreeIoResolution,
                         testing::Values(0.1, 1 / 3., 0.08, 1e-3, 123.456, 0.1 + 0.2));

TEST_P(OctreeIoResolution, OtRoundTripKeepsEveryNodeBitForBit) {
  const auto tree = awkwardTree(GetParam());
  EXPECT_TRUE(sameTree(*tree, *parseOcTreeFile(toOtFile(*tree))));
}

TEST_P(OctreeIoResolution, OctomapReadsOurOtFileBitForBit) {
  const auto tree = awkwardTree(GetParam());
  const auto theirs = readByOctomap(toOtFile(*tree));
  ASSERT_TRUE(theirs);
  EXPECT_TRUE(sameTree(*tree, *theirs));
}

TEST_P(OctreeIoResolution, BtFileKeepsTheResolution) {
  EXPECT_EQ(GetParam(), parseOcTreeFile(toBtFile(*awkwardTree(GetParam())))->getResolution());
}

TEST(OctreeIo, OtFileIsWhatOctomapWrites) {
  const auto tree = awkwardTree(0.25);
  EXPECT_EQ(writtenByOctomap(*tree), toOtFile(*tree));
}

TEST(OctreeIo, WritingLeavesTheTreeAsItWas) {
  const auto tree = awkwardTree(0.1);
  const auto before = nodesOf(*tree);
  toOtFile(*tree);
  toBtFile(*tree);
  EXPECT_TRUE(sameNodes(before, nodesOf(*tree)));
}

TEST(OctreeIo, ReadsTheOtFilesThatOctomapWrites) {
  for (const double resolution : {0.1, 1 / 3.}) {
    const auto tree = awkwardTree(resolution);
    std::ostringstream out;  // with OctoMap's six digits of the resolution
    tree->write(out);
    const auto theirs = readByOctomap(out.str());
    ASSERT_TRUE(theirs);
    EXPECT_TRUE(sameTree(*theirs, *parseOcTreeFile(out.str())));
  }
}

TEST(OctreeIo, ReadsTheOccupancyOfAColouredOtFile) {
  octomap::ColorOcTree coloured(0.1);
  OcTree plain(0.1);
  std::mt19937 rng(5);
  std::uniform_int_distribution<int> place(-30, 30);
  std::uniform_real_distribution<float> value(-1.9F, 3.4F);
  for (int i = 0; i < 200; i++) {
    const auto key = keyOf({place(rng), place(rng), place(rng)});
    const float v = value(rng);
    coloured.setNodeValue(key, v)->setColor(static_cast<uint8_t>(i), 200, 7);
    plain.setNodeValue(key, v);
  }
  const auto read = parseOcTreeFile(writtenByOctomap(coloured));
  EXPECT_TRUE(sameNodes(leavesOf(plain), leavesOf(*read)));
  EXPECT_EQ(coloured.size(), read->size());
}

// ---------------------------------------------------------------- .bt

TEST(OctreeIo, BtFileIsWhatOctomapWrites) {
  const auto tree = sceneTree(0.1, 1);
  EXPECT_EQ(btWrittenByOctomap(*tree), toBtFile(*tree));
}

TEST(OctreeIo, BtFileTellsOccupiedFromFree) {
  const auto tree = sceneTree(0.1, 2);
  const auto read = voxelsOf(*parseOcTreeFile(toBtFile(*tree)));
  const OcTree fresh(0.1);
  auto expected = voxelsOf(*tree);
  for (auto& [k, v] : expected)
    v = v >= tree->getOccupancyThresLog() ? fresh.getClampingThresMaxLog()
                                          : fresh.getClampingThresMinLog();
  EXPECT_TRUE(sameVoxels(expected, read));
}

TEST(OctreeIo, ReadsTheBtFilesThatOctomapWrites) {
  const auto tree = sceneTree(0.1, 3);
  const std::string bytes = btWrittenByOctomap(*tree);
  OcTree theirs(1.0);
  std::istringstream in(bytes);
  ASSERT_TRUE(theirs.readBinary(in));
  EXPECT_TRUE(sameTree(theirs, *parseOcTreeFile(bytes)));
}

TEST(OctreeIo, ReadsARealBuildingAsOctomapDoes) {
  const std::string path = "/usr/share/doc/liboctomap-dev/examples/data/geb079.bt";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not installed";
  const OcTree theirs(path);
  ASSERT_GT(theirs.size(), 100000U);
  EXPECT_TRUE(sameTree(theirs, *parseOcTreeFile(readFileBytes(path))));
}

// ---------------------------------------------------------------- empty and bad files

TEST(OctreeIo, AnEmptyTreeStaysEmpty) {
  const OcTree empty(0.2);
  for (const std::string& bytes : {toOtFile(empty), toBtFile(empty)}) {
    const auto read = parseOcTreeFile(bytes);
    EXPECT_EQ(nullptr, read->getRoot());
    EXPECT_EQ(0U, read->size());
    EXPECT_EQ(0.2, read->getResolution());
  }
  const auto theirs = readByOctomap(toOtFile(empty));
  ASSERT_TRUE(theirs);
  EXPECT_EQ(0U, theirs->size());
  EXPECT_EQ("", serializeNodes(empty));
  OcTree untouched(0.2);
  EXPECT_EQ(0U, parseNodes("", untouched));
  EXPECT_EQ(nullptr, untouched.getRoot());
}

TEST(OctreeIo, EveryTruncationOfAFileIsAnError) {
  const auto tree = smallTree();
  for (const std::string& bytes : {toOtFile(*tree), toBtFile(*tree)}) {
    ASSERT_NO_THROW(parseOcTreeFile(bytes));
    for (size_t n = 0; n < bytes.size(); n++)
      EXPECT_THROW(parseOcTreeFile(bytes.substr(0, n)), std::runtime_error)
          << n << " of " << bytes.size() << " bytes";
  }
}

TEST(OctreeIo, FlippedBitsNeverCrash) {
  std::mt19937 rng(11);
  const auto tree = smallTree();
  for (const std::string& good : {toOtFile(*tree), toBtFile(*tree)})
    for (int i = 0; i < 20000; i++) {
      std::string bytes = good;
      for (unsigned flips = 1 + rng() % 3; flips > 0; flips--)
        bytes[rng() % bytes.size()] ^= static_cast<char>(1U << (rng() % 8));
      expectTreeOrError(bytes);
    }
}

TEST(OctreeIo, RandomDataBehindAHeaderNeverCrashes) {
  std::mt19937 rng(12);
  for (int i = 0; i < 5000; i++) {
    std::string data(rng() % 200, '\0');
    for (char& c : data) c = static_cast<char>(rng());
    expectTreeOrError(otHeader("9") + data);
    expectTreeOrError(kBtLine + "id OcTree\nsize 9\nres 0.1\ndata\n" + data);
  }
}

TEST(OctreeIo, NodesReachDepth16AndNoDeeper) {
  for (const auto& chain : {chainOfNodes, btChainOfNodes}) {
    const auto deepest = parseOcTreeFile(chain(16));
    ASSERT_EQ(17U, deepest->size());
    EXPECT_EQ(16U, leavesOf(*deepest).front().depth);
    EXPECT_NE(std::string::npos,
              errorOf([&] { parseOcTreeFile(chain(17)); }).find("deeper than 16"));
    // Deep enough to end the stack, if depth were only checked at the end.
    EXPECT_THROW(parseOcTreeFile(chain(2000000)), std::runtime_error);
  }
}

TEST(OctreeIo, LogOddsThatAreNoNumberAreAnError) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(parseOcTreeFile(otHeader("1") + otNode(nan, 0)), std::runtime_error);
  EXPECT_THROW(parseOcTreeFile(otHeader("2") + otNode(1, 1) + otNode(nan, 0)), std::runtime_error);
  EXPECT_NO_THROW(parseOcTreeFile(otHeader("2") + otNode(1, 1) + otNode(1, 0)));
}

TEST(OctreeIo, NodesOfAMapInMemoryMustBeFinite) {
  for (const float v :
       {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    OcTree tree(0.1);
    EXPECT_THROW(parseNodes(otNode(v, 0), tree), std::runtime_error);
  }
}

TEST(OctreeIo, AnotherFirstLineIsNotAnOctree) {
  const std::string good = toOtFile(*smallTree());
  for (const std::string& bytes :
       {std::string(), std::string("hello"), "\n" + good, " " + good, good.substr(1),
        std::string("# Octomap PointCloud file\n") + good.substr(kOtLine.size())}) {
    EXPECT_FALSE(mrpt::fusion::isOcTreeFile(bytes));
    EXPECT_THROW(parseOcTreeFile(bytes), std::runtime_error);
  }
  EXPECT_TRUE(mrpt::fusion::isOcTreeFile(good));
  EXPECT_TRUE(mrpt::fusion::isOcTreeFile(toBtFile(*smallTree())));
}

TEST(OctreeIo, AResolutionThatIsNoLengthIsAnError) {
  const std::string node = otNode(1, 0);
  EXPECT_NO_THROW(parseOcTreeFile(otHeader("1") + node));
  for (const char* resolution : {"0.0001", "1e6"})
    EXPECT_NO_THROW(parseOcTreeFile(otHeader("1", resolution) + node)) << resolution;
  for (const char* resolution : {"0", "-1", "nan", "inf", "-inf", "", "abc", "1e999", "1e38",
                                 "1.7e308", "1.1e6", "0.00009", "1e-310"})
    EXPECT_THROW(parseOcTreeFile(otHeader("1", resolution) + node), std::runtime_error)
        << resolution;
  EXPECT_THROW(parseOcTreeFile(kOtLine + "id OcTree\nsize 1\ndata\n" + node), std::runtime_error);
}

TEST(OctreeIo, ANodeCountThatIsNoNumberIsAnError) {
  const std::string nodes = otNode(1, 1) + otNode(1, 0);
  EXPECT_NO_THROW(parseOcTreeFile(otHeader("2") + nodes));
  for (const char* size : {"18446744073709551615", "", "two"})
    EXPECT_THROW(parseOcTreeFile(otHeader(size) + nodes), std::runtime_error) << size;
  EXPECT_THROW(parseOcTreeFile(kOtLine + "id OcTree\nres 0.1\ndata\n" + nodes), std::runtime_error);
}

TEST(OctreeIo, TreesOfOtherTypesAreNamedInTheError) {
  const std::string rest = "\nsize 1\nres 0.1\ndata\n" + otNode(1, 0);
  EXPECT_NO_THROW(parseOcTreeFile(kOtLine + "id OcTree" + rest));
  EXPECT_NE(std::string::npos, errorOf([&] {
                                 parseOcTreeFile(kOtLine + "id CountingOcTree" + rest);
                               }).find("CountingOcTree"));
  EXPECT_THROW(parseOcTreeFile(kOtLine + "id" + rest), std::runtime_error);
  EXPECT_THROW(parseOcTreeFile(kOtLine + rest), std::runtime_error);
}

TEST(OctreeIo, ATypeIsNamedWithoutControlCharacters) {
  const std::string error = errorOf([] {
    parseOcTreeFile(kOtLine + "id A\x1b[2J" + std::string(500, 'x') + "\nsize 1\nres 0.1\ndata\n" +
                    otNode(1, 0));
  });
  EXPECT_NE(std::string::npos, error.find("A\\x1b[2J")) << error;
  EXPECT_LT(error.size(), 100U);
}

TEST(OctreeIo, AHeaderIsNotSearchedWithoutEnd) {
  const std::string lines(std::string(2 << 20, '\n'));
  const std::string error = errorOf([&] { parseOcTreeFile(kOtLine + "id OcTree\n" + lines); });
  EXPECT_NE(std::string::npos, error.find("longer than 1048576 bytes")) << error;
}

TEST(OctreeIo, CommentsInAHeaderAreSkipped) {
  const auto tree = smallTree();
  std::string bytes = toOtFile(*tree);
  bytes.insert(kOtLine.size(), "# data\n#data\n# size 77\n# " + std::string(5000, 'x') + "\n");
  EXPECT_TRUE(sameTree(*tree, *parseOcTreeFile(bytes)));
}

// ---------------------------------------------------------------- files

TEST(OctreeIo, ALargeMapIsSavedAsItsBytesAre) {
  octomap::OcTree tree(0.125);  // of more nodes than go into a block
  for (int i = 0; i < 20000; i++)
    tree.updateNode(
        octomap::OcTreeKey(static_cast<octomap::key_type>(30000 + 7 * (i % 140)),
                           static_cast<octomap::key_type>(30000 + 5 * (i / 140)), 32768),
        i % 3 == 0);
  ASSERT_GT(tree.size(), 40000U);
  const TempDir dir;
  mrpt::fusion::saveOcTree(tree, dir.path("map.ot"));
  EXPECT_TRUE(toOtFile(tree) == readRaw(dir.path("map.ot")));
  EXPECT_TRUE(writtenByOctomap(tree) == readRaw(dir.path("map.ot")));
}
