// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the serialization of CProbOctoMap. */

#include <mrpt/rtti/CObject.h>

#include "support/mrpt_tools.h"
using namespace map_tests;
using mrpt::maps::CProbOctoMap;

namespace {

/** Returns a map in which no field has its default. */
CProbOctoMap unusualMap(std::unique_ptr<octomap::OcTree> tree) {
  // No probability has exactly these log-odds, so they must be serialized as floats.
  mrpt::fusion::OcTreeAccess::setSensorModel(
      *tree, {-1.2345678F, 4.5678912F, 0.91234567F, -0.3456789F, 0.1234567F});
  CProbOctoMap map(std::move(tree));
  auto& i = map.insertionOptions;
  i.maxrange = 7.125;
  i.pruning = false;
  i.occupancyThres = 0.55;
  i.probHit = 0.81;
  i.probMiss = 0.33;
  i.clampingThresMin = 0.07;
  i.clampingThresMax = 0.96;
  map.likelihoodOptions.decimation = 5;
  map.renderingOptions.generateGridLines = true;
  map.renderingOptions.generateOccupiedVoxels = false;
  map.renderingOptions.visibleOccupiedVoxels = false;
  map.renderingOptions.generateFreeVoxels = false;
  map.renderingOptions.visibleFreeVoxels = false;
  map.genericMapParams.enableSaveAs3DObject = false;
  map.genericMapParams.enableObservationLikelihood = false;
  map.genericMapParams.enableObservationInsertion = false;
  return map;
}

testing::AssertionResult sameMap(const CProbOctoMap& a, const CProbOctoMap& b) {
  if (const auto same = sameTree(a.octree(), b.octree()); !same) return same;
  if (sensorModelBits(a.octree()) != sensorModelBits(b.octree()))
    return testing::AssertionFailure() << "sensor models differ";
  const auto options = [](const CProbOctoMap& m) {
    const auto& i = m.insertionOptions;
    const auto& r = m.renderingOptions;
    const auto& g = m.genericMapParams;
    return std::make_tuple(i.maxrange, i.pruning, i.occupancyThres, i.probHit, i.probMiss,
                           i.clampingThresMin, i.clampingThresMax, m.likelihoodOptions.decimation,
                           r.generateGridLines, r.generateOccupiedVoxels, r.visibleOccupiedVoxels,
                           r.generateFreeVoxels, r.visibleFreeVoxels, g.enableSaveAs3DObject,
                           g.enableObservationLikelihood, g.enableObservationInsertion);
  };
  if (options(a) != options(b)) return testing::AssertionFailure() << "options differ";
  return testing::AssertionSuccess();
}

/** The bytes of a map, and the position of the length of its nodes. */
struct MapBytes {
  std::string bytes;
  size_t length_at;
};

MapBytes bytesOf(const CProbOctoMap& map) {
  MapBytes b{serialized(map), 0};
  const std::string nodes = mrpt::fusion::serializeNodes(map.octree());
  b.length_at = b.bytes.find(nodes) - sizeof(uint64_t);
  return b;
}

}  // namespace

TEST(ProbOctoMapSerialization, KeepsEveryNodeAndOptionBitForBit) {
  const CProbOctoMap map = unusualMap(awkwardTree(1 / 3.));
  const auto read = std::dynamic_pointer_cast<CProbOctoMap>(deserialized(serialized(map)));
  ASSERT_TRUE(read);
  EXPECT_TRUE(sameMap(map, *read));
}

TEST(ProbOctoMapSerialization, IntoAMapThatHasContentsReplacesAllOfThem) {
  const CProbOctoMap map(awkwardTree(0.1));
  CProbOctoMap target = unusualMap(smallTree());
  deserializeInto(serialized(map), target);
  EXPECT_TRUE(sameMap(map, target));
}

TEST(ProbOctoMapSerialization, AnEmptyMapStaysEmpty) {
  const CProbOctoMap map(0.37);
  const auto read = std::dynamic_pointer_cast<CProbOctoMap>(deserialized(serialized(map)));
  ASSERT_TRUE(read);
  EXPECT_TRUE(sameMap(map, *read));
  EXPECT_TRUE(read->isEmpty());
}

TEST(ProbOctoMapSerialization, LeavesTheSourceAsItWas) {
  const CProbOctoMap map = unusualMap(awkwardTree(0.1));
  const CProbOctoMap before = map;
  serialized(map);
  EXPECT_TRUE(sameMap(before, map));
}

TEST(ProbOctoMapSerialization, ATruncatedStreamThrowsAndLeavesTheTargetAsItWas) {
  const std::string bytes = serialized(unusualMap(smallTree()));
  const CProbOctoMap before(sceneTree(0.2, 1));
  CProbOctoMap target = before;
  for (size_t n = 0; n < bytes.size(); n++) {
    ASSERT_ANY_THROW(deserializeInto(bytes.substr(0, n), target)) << n << " of " << bytes.size();
    // MRPT looks for the end mark, the last byte, when the map has been read.
    if (n + 1 < bytes.size()) {
      ASSERT_TRUE(sameMap(before, target)) << n << " of " << bytes.size() << " bytes";
    }
  }
}

TEST(ProbOctoMapSerialization, ATruncationInALargeMapThrowsAndLeavesTheTargetAsItWas) {
  // More than one of the blocks in which the nodes are read.
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  for (int x = 0; x < 100; x++)
    for (int y = 0; y < 100; y++)
      for (int z = 0; z < 30; z++)
        putVoxel(*tree, {x, y, z}, 0.5F + 0.001F * static_cast<float>((x + y + z) % 7));
  const std::string bytes = serialized(CProbOctoMap(std::move(tree)));
  ASSERT_GT(bytes.size(), 1500000U);
  const CProbOctoMap before(smallTree());
  CProbOctoMap target = before;
  for (const size_t missing : {size_t{2}, size_t{1000}, bytes.size() - 1200000,
                               bytes.size() - (1U << 20), bytes.size() - 1000}) {
    ASSERT_ANY_THROW(deserializeInto(bytes.substr(0, bytes.size() - missing), target)) << missing;
    ASSERT_TRUE(sameMap(before, target)) << missing << " bytes missing";
  }
}

TEST(ProbOctoMapSerialization, AnUnknownVersionThrows) {
  std::string bytes = serialized(CProbOctoMap(smallTree()));
  const std::string name = "CProbOctoMap";
  const size_t version_at = bytes.find(name) + name.size();
  ASSERT_EQ(0, bytes[version_at]);
  CProbOctoMap target;
  ASSERT_NO_THROW(deserializeInto(bytes, target));
  const CProbOctoMap before = target;
  for (const char version : {'\2', '\3', '\x7f'}) {
    bytes[version_at] = version;
    const std::string error = errorOf([&] { deserializeInto(bytes, target); });
    EXPECT_NE(std::string::npos, error.find("unknown serialization version")) << error;
    EXPECT_TRUE(sameMap(before, target));
  }
}

TEST(ProbOctoMapSerialization, ALengthThatLiesThrowsWithoutTakingMuchMemory) {
  const MapBytes good = bytesOf(CProbOctoMap(smallTree()));
  const auto peakMegabytes = [] {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1024;
  };
  for (const uint64_t length : {uint64_t{1} << 30, uint64_t{1} << 40, ~uint64_t{0}}) {
    std::string bytes = good.bytes;
    std::memcpy(&bytes[good.length_at], &length, sizeof(length));
    // In another process, so that its peak of memory is that of this reading.
    EXPECT_EXIT(
        {
          const auto before = peakMegabytes();
          const bool threw = !errorOf([&] { deserialized(bytes); }).empty();
          ::_exit(!threw ? 1 : peakMegabytes() - before > 200 ? 2 : 0);
        },
        testing::ExitedWithCode(0), "")
        << length;
  }
}

TEST(ProbOctoMapSerialization, FlippedBitsNeverCrash) {
  const std::string good = serialized(unusualMap(smallTree()));
  std::mt19937 rng(13);
  size_t errors = 0;
  for (int i = 0; i < 3000; i++) {
    std::string bytes = good;
    bytes[rng() % bytes.size()] ^= static_cast<char>(1U << (rng() % 8));
    CProbOctoMap target(0.5);
    errors += !errorOf([&] { deserializeInto(bytes, target); }).empty();
    for (const auto& node : nodesOf(target.octree())) ASSERT_LE(node.depth, 16U);
  }
  EXPECT_GT(errors, 0U);
}

TEST(ProbOctoMapSerialization, TheClassIsRegistered) {
  const auto* id = mrpt::rtti::findRegisteredClass("mrpt::maps::CProbOctoMap");
  ASSERT_NE(nullptr, id);
  EXPECT_TRUE(id->derivedFrom("mrpt::maps::CMetricMap"));
  EXPECT_TRUE(std::dynamic_pointer_cast<CProbOctoMap>(id->createObject()));
}

TEST(ProbOctoMapCopy, IsDeepInBothDirections) {
  CProbOctoMap map = unusualMap(awkwardTree(0.1));
  const CProbOctoMap constructed = map;
  CProbOctoMap assigned(0.7);
  assigned = map;
  EXPECT_TRUE(sameMap(map, constructed));
  EXPECT_TRUE(sameMap(map, assigned));
  const auto cloned = std::dynamic_pointer_cast<CProbOctoMap>(map.duplicateGetSmartPtr());
  ASSERT_TRUE(cloned);
  EXPECT_TRUE(sameMap(map, *cloned));

  map.clear();
  EXPECT_TRUE(map.isEmpty());
  EXPECT_TRUE(sameMap(constructed, assigned));
  EXPECT_FALSE(constructed.isEmpty());
  assigned.octree().getRoot()->setLogOdds(9);
  EXPECT_FALSE(sameMap(constructed, assigned));
  EXPECT_TRUE(sameMap(constructed, *cloned));
}

TEST(ProbOctoMapCopy, AssignmentToItselfChangesNothing) {
  CProbOctoMap map = unusualMap(awkwardTree(0.1));
  const CProbOctoMap before = map;
  const CProbOctoMap& itself = map;
  map = itself;
  EXPECT_TRUE(sameMap(before, map));
}

TEST(ProbOctoMapCopy, AMoveTakesEverythingAlong) {
  CProbOctoMap map = unusualMap(awkwardTree(0.1));
  const CProbOctoMap before = map;
  CProbOctoMap constructed = std::move(map);
  EXPECT_TRUE(sameMap(before, constructed));
  CProbOctoMap assigned(0.7);
  assigned = std::move(constructed);
  EXPECT_TRUE(sameMap(before, assigned));
}
