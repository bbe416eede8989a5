// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of what a small stream may cost. */

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/map_files.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/obs/CObservationLocalMap.h>

#include <thread>

#include "fusion_link/map_index.h"
#include "mrpt_fusion_maps/archives/crafted.h"
#include "mrpt_fusion_maps/archives/packed_nodes.h"
#include "mrpt_fusion_maps/edge_cost.h"
#include "mrpt_fusion_maps/recordings/gz_stream.h"
using namespace map_tests;
using mrpt::fusion::compressNodes;
using mrpt::fusion::EdgeVoxels;
using mrpt::fusion::Packing;
using mrpt::fusion::ReadingBudget;
using mrpt::fusion::unpackNodes;
using mrpt::maps::CEdgeVoxelMap;

namespace {

/** Returns an octree with a cube of leaves that are not pruned. */
std::unique_ptr<octomap::OcTree> cubeOfVoxels(int side, float log_odds) {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  for (int x = 0; x < side; x++)
    for (int y = 0; y < side; y++)
      for (int z = 0; z < side; z++) putVoxel(*tree, {x, y, z}, log_odds);
  tree->updateInnerOccupancy();
  return tree;
}

EdgeVoxels fewEdges() {
  EdgeVoxels edges;
  edges.resolution = 0.1;
  edges.direction_radius = 0.625;
  for (int i = 0; i < 12; i++) {
    edges.centre.emplace_back(0.05F + 0.1F * static_cast<float>(i), 0.05F, i % 2 ? 0.05F : 1.25F);
    edges.probability.push_back(0.7F + 0.02F * static_cast<float>(i));
  }
  return edges;
}

/** Returns a serialized CEdgeVoxelMap with other edge voxels and another radius of eq. (6). */
std::string edgeMapOf(const octomap::OcTree& probabilities, double radius) {
  const EdgeVoxels few = fewEdges();
  const std::string old = compressNodes(mrpt::fusion::probabilityTree(few), Packing::Smallest);
  const std::string packed = compressNodes(probabilities, Packing::Smallest);
  const std::string bytes =
      replaced(serialized(CEdgeVoxelMap(few)), bytesOfValue(uint64_t{old.size()}) + old,
               bytesOfValue(uint64_t{packed.size()}) + packed);
  return withNumber(bytes, few.direction_radius, radius);
}

}  // namespace

// ---------------------------------------------------------------- nodes

TEST(ReadingBudgetNodes, AreSharedByAllObjectsOfAFile) {
  const auto tree = cubeOfVoxels(64, 1.5F);
  const std::string packed = compressNodes(*tree);
  ASSERT_LT(ReadingBudget::kNodesPerByte * packed.size(), tree->size() / 4);
  ReadingBudget budget;
  budget.nodes = 2 * tree->size();
  for (int i = 0; i < 2; i++) {
    octomap::OcTree read(0.1);
    ASSERT_NO_THROW(unpackNodes(packed, budget, read));
    EXPECT_TRUE(sameTree(*tree, read));
  }
  octomap::OcTree third(0.1);
  EXPECT_NE(errorOf([&] { unpackNodes(packed, budget, third); }).find("too many nodes"),
            std::string::npos);
}

TEST(ReadingBudgetNodes, ThatAreInProportionToTheBytesCostNothing) {
  const auto tree = sceneTree(0.1, 3);
  const std::string packed = compressNodes(*tree);
  ASSERT_GT(ReadingBudget::kNodesPerByte * packed.size(), tree->size());
  ReadingBudget budget;
  budget.nodes = 0;
  for (int i = 0; i < 3; i++) {
    octomap::OcTree read(0.1);
    ASSERT_NO_THROW(unpackNodes(packed, budget, read));
  }
}

TEST(ReadingBudgetNodes, OfOneMissionAreBounded) {
  const TempDir dir;
  const auto map = std::make_shared<mrpt::maps::CProbOctoMap>(cubeOfVoxels(128, 1.5F));
  std::vector<mrpt::obs::CObservationLocalMap::Ptr> maps;
  for (int i = 0; i < 4; i++) {
    auto& o = *maps.emplace_back(mrpt::obs::CObservationLocalMap::Create());
    o.sensorLabel = "robot" + std::to_string(i);
    o.map = map;
  }
  mrpt::fusion::saveLocalMaps(maps, dir.path("mission"));
  EXPECT_NE(
      errorOf([&] { mrpt::fusion::loadLocalMaps(dir.path("mission")); }).find("too many nodes"),
      std::string::npos);
}

TEST(ReadingBudgetNodes, AreAlsoTheEntriesOfTheIndicesOfDiffs) {
  const TempDir dir;
  mrpt::fusion::MapIndex index;
  index.version = 1;
  index.hash = mrpt::fusion::hashOf({});
  index.trunk.resolution = 0.1;
  index.trunk.values.resize(16 * mrpt::fusion::kMostBlocks);
  mrpt::obs::CObservationMapDiff diff;
  diff.version = index.version;
  diff.index = toBytes(index);
  ASSERT_LT(ReadingBudget::kNodesPerByte * diff.index.size(), index.trunk.values.size() / 2);
  const auto errorOfRobots = [&](int robots) {
    std::string bytes;
    for (int i = 0; i < robots; i++) {
      diff.sensorLabel = "robot" + std::to_string(i);
      bytes += serialized(diff);
    }
    writeRaw(dir.path("mission"), bytes);
    return errorOf([&] { mrpt::fusion::loadLocalMaps(dir.path("mission")); });
  };
  EXPECT_EQ(errorOfRobots(3), "");
  EXPECT_NE(errorOfRobots(10).find("too many nodes"), std::string::npos);
}

// ---------------------------------------------------------------- covariances of edges

TEST(EdgeVoxelMap, WhoseCovariancesTakeTooLongIsAnError) {
  const auto dense = cubeOfVoxels(64, 0.75F);
  const std::string error = errorOf([&] { deserialized(edgeMapOf(*dense, 6.25)); });
  EXPECT_NE(error.find("too dense"), std::string::npos) << error;
}

TEST(EdgeVoxelMap, ComputesItsCovariancesAtTheFirstUse) {
  const CEdgeVoxelMap map(fewEdges());
  const auto read = std::dynamic_pointer_cast<CEdgeVoxelMap>(deserialized(serialized(map)));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->size(), map.size());
  EXPECT_EQ(read->getResolution(), map.getResolution());
  const CEdgeVoxelMap copy(*read);  // shares them
  EXPECT_EQ(serialized(copy), serialized(map));
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; i++) threads.emplace_back([&] { read->edges(); });
  for (auto& thread : threads) thread.join();
  ASSERT_EQ(copy.edges().covariance.size(), map.edges().covariance.size());
  for (size_t i = 0; i < map.size(); i++)
    EXPECT_EQ(copy.edges().covariance[i].linearity(), map.edges().covariance[i].linearity()) << i;
  EXPECT_TRUE(sameTree(map.asOcTree(), copy.asOcTree()));
}

TEST(EdgePairs, AreAtLeastThePairsWithinTheRadius) {
  std::mt19937 rng(3);
  std::uniform_int_distribution<int> place(0, 30);
  std::set<std::array<unsigned, 3>> places;
  std::vector<octomap::OcTreeKey> keys;
  for (int i = 0; i < 500; i++) {
    const octomap::OcTreeKey k = keyOf({place(rng), place(rng), place(rng)});
    if (places.insert({k[0], k[1], k[2]}).second) keys.push_back(k);
  }
  for (const double radius : {0.5, 1.0, 2.5, 7.0, 64.0}) {
    uint64_t pairs = 0;
    for (const auto& k : keys)
      for (const auto& l : keys)
        pairs += std::hypot(k[0] - l[0], k[1] - l[1], k[2] - l[2]) <= radius ? 1 : 0;
    const uint64_t bound = mrpt::fusion::edgePairs(keys, radius);
    EXPECT_GE(bound, pairs) << radius;
    EXPECT_LE(bound, keys.size() * keys.size()) << radius;
  }
}

// ---------------------------------------------------------------- bytes

TEST(GzStream, RefusesDataThatUnpacksToFarMoreBytes) {
  const TempDir dir;
  constexpr size_t kLabel = size_t{100} << 20U;
  mrpt::obs::CObservationLocalMap o;
  o.sensorLabel = "robot";
  const std::string label = bytesOfValue(uint64_t{5}) + "robot";
  const std::string bytes =
      replaced(serialized(o), label, bytesOfValue(uint64_t{kLabel}) + std::string(kLabel, 'x'));
  writeRaw(dir.path("plain"), bytes);
  EXPECT_EQ(errorOf([&] { mrpt::fusion::loadLocalMaps(dir.path("plain")); }), "");
  writeRaw(dir.path("packed"), mrpt::fusion::gzCompressed(bytes));
  const std::string error = errorOf([&] { mrpt::fusion::loadLocalMaps(dir.path("packed")); });
  EXPECT_NE(error.find("unpacks to more"), std::string::npos) << error;
}
