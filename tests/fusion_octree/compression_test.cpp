// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_octree/compression.h"

#include "support/tree_tools.h"
using namespace map_tests;
using mrpt::fusion::compressNodes;
using mrpt::fusion::decompressNodes;

namespace {

octomap::OcTree decompressed(const std::string& bytes, double resolution = 0.1) {
  octomap::OcTree tree(resolution);
  decompressNodes(bytes, tree);
  return tree;
}

/** Each leaf with a value of its own. */
std::unique_ptr<octomap::OcTree> diverseTree() {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  float value = -2;
  for (int x = 0; x < 40; x++)
    for (int y = 0; y < 40; y++) putVoxel(*tree, {x, y, (x * y) % 7}, value += 0.00123F);
  finish(*tree);
  return tree;
}

}  // namespace

TEST(OcTreeCompression, KeepsEveryNodeBitForBit) {
  for (const double resolution : {0.1, 1 / 3.})
    for (const auto& tree : {awkwardTree(resolution), sceneTree(resolution, 7)})
      EXPECT_TRUE(sameTree(*tree, decompressed(compressNodes(*tree), resolution)));
  for (const auto& tree : {smallTree(), diverseTree()})
    EXPECT_TRUE(sameTree(*tree, decompressed(compressNodes(*tree))));
}

TEST(OcTreeCompression, KeepsInnerNodesThatWereNotUpdated) {
  const auto tree = sceneTree(0.1, 3);
  tree->getRoot()->setLogOdds(0.123F);
  for (int x = 0; x < 50; x++) {  // lazily: the nodes above do not follow
    const octomap::OcTreeKey key(static_cast<octomap::key_type>(32768 + x), 32768, 32768);
    tree->setNodeValue(key, 3.1F, true);
  }
  EXPECT_TRUE(sameTree(*tree, decompressed(compressNodes(*tree))));
}

TEST(OcTreeCompression, AnEmptyTreeAndASingleNode) {
  octomap::OcTree tree(0.1);
  EXPECT_TRUE(sameTree(tree, decompressed(compressNodes(tree))));
  mrpt::fusion::OcTreeAccess::createRoot(tree)->setLogOdds(1.5F);  // all of space is alike
  EXPECT_TRUE(sameTree(tree, decompressed(compressNodes(tree))));
}

TEST(OcTreeCompression, IsFarSmallerThanTheNodes) {
  const auto tree = sceneTree(0.1, 5);
  EXPECT_LT(compressNodes(*tree).size(), mrpt::fusion::serializeNodes(*tree).size() / 4);
}

TEST(OcTreeCompression, TruncatedOrTrailingBytesAreAnError) {
  const std::string bytes = compressNodes(*smallTree());
  for (size_t n = 0; n < bytes.size(); n++)
    EXPECT_NE(errorOf([&] { decompressed(bytes.substr(0, n)); }), "")
        << n << " of " << bytes.size();
  EXPECT_NE(errorOf([&] { decompressed(bytes + "x"); }), "");
}

TEST(OcTreeCompression, DamagedBytesAreAnError) {
  const std::string good = compressNodes(*sceneTree(0.1, 2));
  std::mt19937 rng(5);
  for (int i = 0; i < 300; i++) {
    std::string bytes = good;
    bytes[rng() % bytes.size()] ^= static_cast<char>(1U << (rng() % 8));
    octomap::OcTree tree(0.1);
    const std::string error = errorOf([&] { decompressNodes(bytes, tree); });
    if (error.empty()) {  // bits that mean nothing
      EXPECT_TRUE(sameTree(*sceneTree(0.1, 2), tree));
    }
  }
}
