// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_octree/compression.h"

#include <lzma.h>

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

/** Returns bytes in the format that compressNodes() packs its data in. */
std::string packed(const std::string& data) {
  std::string out(::lzma_stream_buffer_bound(data.size()), '\0');
  size_t size = 0;
  EXPECT_EQ(::lzma_easy_buffer_encode(0, LZMA_CHECK_CRC32, nullptr,
                                      reinterpret_cast<const uint8_t*>(data.data()), data.size(),
                                      reinterpret_cast<uint8_t*>(out.data()), &size, out.size()),
            LZMA_OK);
  out.resize(size);
  return out;
}

/** Returns the beginning of the data: the numbers of masks, leaves and exceptions. */
std::string counts(uint64_t masks, uint64_t leaves, uint64_t exceptions) {
  std::string bytes;
  for (const uint64_t n : {masks, leaves, exceptions})
    bytes.append(reinterpret_cast<const char*>(&n), sizeof(n));
  return bytes;
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

TEST(OcTreeCompression, MoreNodesThanAllowedAreAnError) {
  const auto tree = sceneTree(0.1, 2);
  const std::string bytes = compressNodes(*tree);
  octomap::OcTree same(0.1), less(0.1);
  decompressNodes(bytes, same, tree->size());
  EXPECT_TRUE(sameTree(*tree, same));
  EXPECT_NE(errorOf([&] { decompressNodes(bytes, less, tree->size() - 1); }), "");
}

TEST(OcTreeCompression, CountsThatTheDataDoesNotHoldTakeNoMemory) {
  const MemoryLimit limit(100);
  constexpr uint64_t kClaimed = 40'000'000;
  const std::string rest(100'000, '\0');
  for (const std::string& data :
       {counts(kClaimed, 1, 0), counts(1, kClaimed, 0), counts(1, 1, kClaimed),
        counts(100, 100, kClaimed), counts(100, kClaimed, 100)}) {
    const std::string error = errorOf([&] { decompressed(packed(data + rest)); });
    EXPECT_NE(error, "");
    EXPECT_EQ(error.find("bad_alloc"), std::string::npos) << error;
  }
}

TEST(OcTreeCompression, BytesBeyondTheCountsAreNotUnpacked) {
  const std::string bytes = packed(counts(1, 1, 0) + std::string(300'000'000, '\0'));
  const MemoryLimit limit(100);
  const std::string error = errorOf([&] { decompressed(bytes); });
  EXPECT_NE(error, "");
  EXPECT_EQ(error.find("bad_alloc"), std::string::npos) << error;
}
