// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_octree/compression.h"

#include <lzma.h>

#include "support/tree_tools.h"
using namespace map_tests;
using mrpt::fusion::compressNodes;
using mrpt::fusion::decompressNodes;
using mrpt::fusion::Packing;

namespace {

constexpr Packing kPackings[] = {Packing::Fast, Packing::Smallest};

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

/** Returns the data as earlier versions packed it: as xz. */
std::string xzPacked(const std::string& data) {
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
  for (const Packing packing : kPackings) {
    for (const double resolution : {0.1, 1 / 3.})
      for (const auto& tree : {awkwardTree(resolution), sceneTree(resolution, 7)})
        EXPECT_TRUE(sameTree(*tree, decompressed(compressNodes(*tree, packing), resolution)));
    for (const auto& tree : {smallTree(), diverseTree()})
      EXPECT_TRUE(sameTree(*tree, decompressed(compressNodes(*tree, packing))));
  }
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
  for (const Packing packing : kPackings)
    EXPECT_LT(compressNodes(*tree, packing).size(), mrpt::fusion::serializeNodes(*tree).size() / 4);
}

TEST(OcTreeCompression, BytesOfVersion0_1AreReadAsBefore) {
  // compressNodes(*smallTree()) of version 0.1.0.
  constexpr char kBytes[] =
      "\xfd\x37\x7a\x58\x5a\x00\x00\x01\x69\x22\xde\x36\x02\xc0\x26\x4c\x21\x01\x00\x00\x90\xb6"
      "\xa0\xbe\xe0\x00\x4b\x00\x1e\x03\x00\x10\x00\x33\x5b\x04\xf7\x1a\xd8\x8c\x8e\x5c\x87\x68"
      "\x2f\xf7\x36\x35\x24\x63\xe9\x04\xaa\x21\x48\x68\x6f\x72\x55\x00\x00\x00\x00\x00\xc9\x4b"
      "\x9c\xd0\x00\x01\x36\x4c\xe5\x29\xf0\xd6\x90\x42\x99\x0d\x01\x00\x00\x00\x00\x01\x59\x5a";
  const std::string bytes(kBytes, sizeof(kBytes) - 1);
  EXPECT_TRUE(sameTree(*smallTree(), decompressed(bytes)));
  EXPECT_EQ(mrpt::fusion::packingOf(bytes), Packing::Smallest);
}

TEST(OcTreeCompression, TheBytesTellThePacking) {
  for (const Packing packing : kPackings)
    EXPECT_EQ(mrpt::fusion::packingOf(compressNodes(*smallTree(), packing)), packing);
  EXPECT_EQ(compressNodes(*smallTree()), compressNodes(*smallTree(), Packing::Fast));
}

TEST(OcTreeCompression, BothPackingsHoldTheSameData) {
  const auto data = [](Packing packing) {
    return mrpt::fusion::unpacked(compressNodes(*sceneTree(0.1, 6), packing),
                                  [](std::string_view) { return uint64_t{1} << 30U; });
  };
  EXPECT_TRUE(data(Packing::Fast) == data(Packing::Smallest));
}

TEST(OcTreeCompression, TruncatedOrTrailingBytesAreAnError) {
  for (const Packing packing : kPackings) {
    const std::string bytes = compressNodes(*smallTree(), packing);
    for (size_t n = 0; n < bytes.size(); n++)
      EXPECT_NE(errorOf([&] { decompressed(bytes.substr(0, n)); }), "")
          << n << " of " << bytes.size();
    EXPECT_NE(errorOf([&] { decompressed(bytes + "x"); }), "");
    EXPECT_NE(errorOf([&] { decompressed(bytes + bytes); }), "");
  }
}

TEST(OcTreeCompression, DamagedBytesAreAnError) {
  const std::string fast = compressNodes(*sceneTree(0.1, 2), Packing::Fast);
  const std::string smallest = compressNodes(*sceneTree(0.1, 2), Packing::Smallest);
  std::mt19937 rng(5);
  for (int i = 0; i < 600; i++) {
    std::string bytes = i % 2 ? fast : smallest;
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
  for (const Packing packing : kPackings) {
    const std::string bytes = compressNodes(*tree, packing);
    octomap::OcTree same(0.1), less(0.1);
    decompressNodes(bytes, same, tree->size());
    EXPECT_TRUE(sameTree(*tree, same));
    EXPECT_NE(errorOf([&] { decompressNodes(bytes, less, tree->size() - 1); }), "");
  }
}

TEST(OcTreeCompression, CountsThatTheDataDoesNotHoldTakeNoMemory) {
  const MemoryLimit limit(100);
  constexpr uint64_t kClaimed = 40'000'000;
  const std::string rest(100'000, '\0');
  for (const std::string& data :
       {counts(kClaimed, 1, 0), counts(1, kClaimed, 0), counts(1, 1, kClaimed),
        counts(100, 100, kClaimed), counts(100, kClaimed, 100)})
    for (const std::string& bytes :
         {xzPacked(data + rest), mrpt::fusion::packed(data + rest, Packing::Fast)}) {
      const std::string error = errorOf([&] { decompressed(bytes); });
      EXPECT_NE(error, "");
      EXPECT_EQ(error.find("bad_alloc"), std::string::npos) << error;
    }
}

TEST(OcTreeCompression, BytesBeyondTheCountsAreNotUnpacked) {
  const std::string data = counts(1, 1, 0) + std::string(300'000'000, '\0');
  for (const std::string& bytes : {xzPacked(data), mrpt::fusion::packed(data, Packing::Fast)}) {
    const MemoryLimit limit(100);
    const std::string error = errorOf([&] { decompressed(bytes); });
    EXPECT_NE(error, "");
    EXPECT_EQ(error.find("bad_alloc"), std::string::npos) << error;
  }
}

TEST(OcTreeCompression, AWindowOfGigabytesIsAnErrorAndTakesNoMemory) {
  // A Zstandard frame with a window of 2 GB, and a block of 3 raw bytes.
  const std::string bytes(
      "\x28\xB5\x2F\xFD\x00\xA8\x19\x00\x00"
      "abc",
      12);
  const MemoryLimit limit(100);
  const std::string error = errorOf([&] { decompressed(bytes); });
  EXPECT_NE(error.find("damaged"), std::string::npos) << error;
}
