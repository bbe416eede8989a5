// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the sources that a CProbOctoMap carries. */

#include <mrpt/obs/CObservationLocalMap.h>

#include <cstring>

#include "fusion_octree/voxel_hash.h"
#include "support/mrpt_tools.h"
using namespace map_tests;
using mrpt::fusion::Sources;
using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationLocalMap;

namespace {

Sources someSources() {
  return {
      {"robot-xyz", "hall", 7, 0x123456789abcdef0}, {{}, "b", 0, 42}, {{}, {}, 0, ~uint64_t{0}}};
}

CProbOctoMap fusedMap() {
  CProbOctoMap map(smallTree());
  map.setSources(someSources());
  return map;
}

/** The version of a serialized CProbOctoMap. */
char versionOf(const std::string& bytes) {
  const std::string name = "CProbOctoMap";
  return bytes[bytes.find(name) + name.size()];
}

}  // namespace

TEST(ProbOctoMapSources, AreKeptByStreamsAndCopies) {
  const CProbOctoMap map = fusedMap();
  EXPECT_EQ(map.sources(), someSources());
  const auto read = std::dynamic_pointer_cast<CProbOctoMap>(deserialized(serialized(map)));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->sources(), someSources());
  EXPECT_TRUE(sameTree(read->octree(), map.octree()));
  CProbOctoMap assigned;
  assigned = map;
  EXPECT_EQ(assigned.sources(), someSources());
  assigned = CProbOctoMap(smallTree());
  EXPECT_TRUE(assigned.sources().empty());
}

TEST(ProbOctoMapSources, AreKeptByMissions) {
  CObservationLocalMap sent;
  sent.map = std::make_shared<CProbOctoMap>(fusedMap());
  const auto read = std::dynamic_pointer_cast<CObservationLocalMap>(deserialized(serialized(sent)));
  ASSERT_TRUE(read && read->map);
  EXPECT_EQ(dynamic_cast<const CProbOctoMap&>(*read->map).sources(), someSources());
}

TEST(ProbOctoMapSources, AMapWithoutSourcesIsWrittenAsBefore) {
  CProbOctoMap map(smallTree());
  const std::string before = serialized(map);
  EXPECT_EQ(versionOf(before), 0);
  map.setSources(someSources());
  const std::string with = serialized(map);
  EXPECT_EQ(versionOf(with), 1);
  map.setSources({});
  EXPECT_EQ(serialized(map), before);
  // A stream of version 0 has no sources.
  map.setSources(someSources());
  deserializeInto(before, map);
  EXPECT_TRUE(map.sources().empty());
}

TEST(ProbOctoMapSources, AreThoseOfTheVoxels) {
  CProbOctoMap map = fusedMap();
  map.updateVoxel(0.05, 0.05, 0.05, true);
  Sources changed = someSources();
  changed.push_back({{}, {}, 0, mrpt::fusion::voxelHash(map.octree())});
  EXPECT_EQ(map.sources(), changed) << "the map has observations that no source has";
  const auto read = std::dynamic_pointer_cast<CProbOctoMap>(deserialized(serialized(map)));
  EXPECT_EQ(read->sources(), changed);
  map.clear();
  EXPECT_TRUE(map.sources().empty());
  map = fusedMap();
  map.setOctree(smallTree());
  EXPECT_TRUE(map.sources().empty());
}

TEST(ProbOctoMapSources, AHashOf0IsThatOfTheMap) {
  CProbOctoMap map(smallTree());
  map.setSources({{"r", {}, 3, 0}});
  EXPECT_EQ(map.sources()[0].content_hash, mrpt::fusion::voxelHash(map.octree()));
}

TEST(ProbOctoMapSources, AreLimited) {
  CProbOctoMap map(smallTree());
  EXPECT_THROW(map.setSources(Sources(100001)), std::length_error);
  map.setSources({{std::string(5000, 'r'), {}, 0, 1}});
  EXPECT_EQ(map.sources()[0].robot.size(), 1000U);
}

TEST(ProbOctoMapSources, ATruncatedStreamThrowsAndLeavesTheTargetAsItWas) {
  const std::string bytes = serialized(fusedMap());
  const CProbOctoMap before(sceneTree(0.2, 1));
  CProbOctoMap target = before;
  for (size_t n = 0; n + 1 < bytes.size(); n++) {
    ASSERT_ANY_THROW(deserializeInto(bytes.substr(0, n), target)) << n << " of " << bytes.size();
    ASSERT_TRUE(sameTree(before.octree(), target.octree())) << n;
    ASSERT_TRUE(target.sources().empty()) << n;
  }
}

TEST(ProbOctoMapSources, NumbersThatLieThrow) {
  const std::string good = serialized(fusedMap());
  const size_t name_at = good.find("robot-xyz");
  const auto errorWith = [&](size_t at, auto number) {
    std::string bytes = good;
    std::memcpy(&bytes[at], &number, sizeof(number));
    CProbOctoMap target;
    return errorOf([&] { deserializeInto(bytes, target); });
  };
  for (const uint64_t length : {uint64_t{1001}, uint64_t{1} << 40, ~uint64_t{0}})
    EXPECT_NE(errorWith(name_at - 8, length).find("a name is too long"), std::string::npos);
  for (const uint32_t count : {uint32_t{100001}, ~uint32_t{0}})
    EXPECT_NE(errorWith(name_at - 12, count).find("too many sources"), std::string::npos);
  EXPECT_FALSE(errorWith(name_at - 12, uint32_t{100000}).empty()) << "more than there are";
  EXPECT_FALSE(errorWith(name_at - 12, uint32_t{2}).empty()) << "fewer than there are";
}
