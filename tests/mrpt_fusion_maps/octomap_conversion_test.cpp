// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/COctoMap.h>

#include "observations.h"
#include "test_tools.h"

using namespace map_tests;
using mrpt::maps::COctoMap;
using mrpt::maps::CProbOctoMap;

namespace {

/** A map with values of many hits and misses, lone voxels and pruned leaves. */
COctoMap theirMap() {
  COctoMap map(0.1);
  map.setProbHit(0.73);
  map.setProbMiss(0.37);
  map.setClampingThresMin(0.02);
  map.setClampingThresMax(0.995);
  std::mt19937 rng(31);
  std::uniform_real_distribution<double> place(-1.5, 1.5);
  for (int i = 0; i < 6000; i++)
    map.updateVoxel(place(rng), place(rng), place(rng), rng() % 2 == 0);
  for (int repeat = 0; repeat < 20; repeat++)
    for (int i = 0; i < 512; i++)
      map.updateVoxel(3.25 + 0.1 * (i & 7), 0.05 + 0.1 * ((i >> 3) & 7), 0.05 + 0.1 * (i >> 6),
                      i % 64 < 32);
  return map;
}

/** Where the leaves are and how large, as drawn: what MRPT shows of a tree's structure. */
template <class Map>
std::map<VoxelIndex, int> leafCubesOf(const Map& map) {
  mrpt::opengl::COctoMapVoxels gl;
  map.getAsOctoMapVoxels(gl);
  std::map<VoxelIndex, int> cubes;
  for (size_t set = 0; set < 2; set++)
    for (size_t i = 0; i < gl.getVoxelCount(set); i++) {
      const auto& v = gl.getVoxel(set, i);
      const auto half_voxels = [&](double length) {
        return static_cast<int>(std::lround(2 * length / map.getResolution()));
      };
      cubes[{half_voxels(v.coords.x), half_voxels(v.coords.y), half_voxels(v.coords.z)}] =
          half_voxels(v.side_length) / 2;
    }
  return cubes;
}

std::map<VoxelIndex, float> logOddsOf(const COctoMap& map) {
  std::map<VoxelIndex, float> voxels;
  for (const auto& [k, p] : occupanciesOf(map)) voxels[k] = octomap::logodds(p);
  return voxels;
}

/** Single voxels with these values, not next to each other. */
CProbOctoMap mapWithValues(const std::vector<float>& values) {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  int i = 0;
  for (const float v : values) {
    putVoxel(*tree, {(i % 50) * 3 - 70, (i / 50) * 3 - 70, 5}, v);
    i++;
  }
  finish(*tree);
  return CProbOctoMap(std::move(tree));
}

std::array<uint32_t, 5> sensorModelBits(const COctoMap& m) {
  return {bitsOf(m.getClampingThresMinLog()), bitsOf(m.getClampingThresMaxLog()),
          bitsOf(m.getProbHitLog()), bitsOf(m.getProbMissLog()), bitsOf(m.getOccupancyThresLog())};
}

CProbOctoMap thereAndBack(const CProbOctoMap& map) {
  COctoMap theirs(0.7);
  map.toOctoMap(theirs);
  return CProbOctoMap(theirs);
}

}  // namespace

// ---------------------------------------------------------------- from a COctoMap

TEST(FromOctoMap, KeepsEveryLeafsLogOddsAndCube) {
  const COctoMap theirs = theirMap();
  CProbOctoMap ours(0.7);
  ours.fromOctoMap(theirs);
  EXPECT_EQ(theirs.getResolution(), ours.getResolution());
  const auto expected = logOddsOf(theirs);
  ASSERT_GT(expected.size(), 4000U);
  EXPECT_TRUE(sameVoxels(expected, voxelsOf(ours.octree())));
  EXPECT_TRUE(sameVoxels(leafCubesOf(theirs), leafCubesOf(ours)));
  EXPECT_EQ(theirs.getNumLeafNodes(), ours.getNumLeafNodes());
  EXPECT_EQ(theirs.size(), ours.size());
}

TEST(FromOctoMap, KeepsTheSensorModelAndOptions) {
  COctoMap theirs = theirMap();
  theirs.setOccupancyThres(0.57);
  theirs.insertionOptions.maxrange = 8.5;
  theirs.insertionOptions.pruning = false;
  theirs.likelihoodOptions.decimation = 3;
  theirs.renderingOptions.visibleFreeVoxels = false;
  theirs.genericMapParams.enableObservationLikelihood = false;
  const CProbOctoMap ours(theirs);
  EXPECT_EQ(sensorModelBits(theirs), map_tests::sensorModelBits(ours.octree()));
  EXPECT_EQ(theirs.getProbHit(), ours.insertionOptions.probHit);
  EXPECT_EQ(theirs.getProbMiss(), ours.insertionOptions.probMiss);
  EXPECT_EQ(theirs.getClampingThresMin(), ours.insertionOptions.clampingThresMin);
  EXPECT_EQ(theirs.getClampingThresMax(), ours.insertionOptions.clampingThresMax);
  EXPECT_EQ(theirs.getOccupancyThres(), ours.insertionOptions.occupancyThres);
  EXPECT_EQ(8.5, ours.insertionOptions.maxrange);
  EXPECT_FALSE(ours.insertionOptions.pruning);
  EXPECT_EQ(3U, ours.likelihoodOptions.decimation);
  EXPECT_FALSE(ours.renderingOptions.visibleFreeVoxels);
  EXPECT_FALSE(ours.genericMapParams.enableObservationLikelihood);
}

TEST(FromOctoMap, LeavesTheSourceAsItWas) {
  const COctoMap theirs = theirMap();
  const auto occupancies = occupanciesOf(theirs);
  const auto cubes = leafCubesOf(theirs);
  const auto model = sensorModelBits(theirs);
  const CProbOctoMap ours(theirs);
  EXPECT_FALSE(ours.isEmpty());
  EXPECT_TRUE(sameVoxels(occupancies, occupanciesOf(theirs)));
  EXPECT_TRUE(sameVoxels(cubes, leafCubesOf(theirs)));
  EXPECT_EQ(model, sensorModelBits(theirs));
}

TEST(FromOctoMap, TakesWhatTheSourceDoesNotDraw) {
  COctoMap theirs = theirMap();
  const CProbOctoMap expected(theirs);
  for (const bool occupied : {false, true}) {
    theirs.renderingOptions.generateOccupiedVoxels = occupied;
    theirs.renderingOptions.generateFreeVoxels = false;
    const CProbOctoMap ours(theirs);
    EXPECT_TRUE(sameTree(expected.octree(), ours.octree()));
    EXPECT_EQ(map_tests::sensorModelBits(expected.octree()),
              map_tests::sensorModelBits(ours.octree()));
    EXPECT_EQ(occupied, theirs.renderingOptions.generateOccupiedVoxels);
    EXPECT_FALSE(theirs.renderingOptions.generateFreeVoxels);
  }
}

TEST(FromOctoMap, TakesLeavesOnEitherSideOfAnyOccupancyThreshold) {
  COctoMap theirs = theirMap();
  const auto expected = logOddsOf(theirs);
  for (const double threshold : {0.2, 0.8}) {
    theirs.setOccupancyThres(threshold);
    EXPECT_TRUE(sameVoxels(expected, voxelsOf(CProbOctoMap(theirs).octree())));
  }
}

TEST(FromOctoMap, KeepsVoxelsFarFromTheOrigin) {
  for (const double resolution : {0.1, 0.01, 1 / 3.}) {
    COctoMap theirs(resolution);
    for (const int k : {-32768, -32767, -16385, -16384, -1, 0, 16383, 16384, 32766, 32767}) {
      const double x = (k + 0.5) * resolution;
      theirs.updateVoxel(x, -x, 0.5 * resolution, k % 3 == 0);
    }
    const CProbOctoMap ours(theirs);
    EXPECT_EQ(10U, ours.getNumLeafNodes());
    EXPECT_TRUE(sameVoxels(logOddsOf(theirs), voxelsOf(ours.octree()))) << resolution;
  }
}

TEST(FromOctoMap, AnUnprunedMapKeepsEveryValue) {
  COctoMap theirs(0.1);  // with its default options, COctoMap never prunes what it inserts
  for (int i = 0; i < 10; i++) theirs.insertObservation(*cloudOf(domePoints(1, 2000)));
  const CProbOctoMap ours(theirs);
  EXPECT_TRUE(sameVoxels(logOddsOf(theirs), voxelsOf(ours.octree())));
}

TEST(FromOctoMap, AnEmptyMapIsEmpty) {
  const CProbOctoMap ours{COctoMap(0.25)};
  EXPECT_TRUE(ours.isEmpty());
  EXPECT_EQ(0.25, ours.getResolution());
}

TEST(FromOctoMap, SaturatedVoxelsStayFinite) {
  // MRPT's probability of these is exactly 0 or 1, from which no log-odds come back; a tree that
  // holds an infinity could be saved but never loaded again.
  COctoMap theirs(0.1);
  theirs.setClampingThresMin(1e-300);
  theirs.setClampingThresMax(1);
  for (int i = 0; i < 200; i++) {
    theirs.updateVoxel(0.05, 0.05, 0.05, true);
    theirs.updateVoxel(1.05, 0.05, 0.05, false);
  }
  const CProbOctoMap ours(theirs);
  for (const auto& [k, v] : voxelsOf(ours.octree())) {
    EXPECT_TRUE(std::isfinite(v)) << v;
    EXPECT_GT(std::abs(v), 36);
  }
}

// ---------------------------------------------------------------- to a COctoMap and back

TEST(ToOctoMap, AndBackKeepsEveryLeafBitForBit) {
  for (unsigned seed = 0; seed < 3; seed++) {
    const CProbOctoMap map(sceneTree(0.1, seed));
    EXPECT_TRUE(sameTree(map.octree(), thereAndBack(map).octree()));
  }
}

TEST(ToOctoMap, AndBackKeepsPrunedLeaves) {
  auto tree = std::make_unique<octomap::OcTree>(1 / 3.);
  putLeaf(*tree, {-8, -8, -8}, 13, 2.75F);
  putLeaf(*tree, {16, 0, 0}, 12, -1.3F);
  putVoxel(*tree, {-9, -9, -9}, 0.4F);
  finish(*tree);
  const CProbOctoMap map(std::move(tree));
  EXPECT_TRUE(sameTree(map.octree(), thereAndBack(map).octree()));
}

TEST(ToOctoMap, AndBackKeepsValuesThatObservationsMake) {
  CProbOctoMap map(0.1);
  for (int i = 0; i < 3; i++) map.insertObservation(*cloudOf(domePoints(41)));
  map.insertObservation(*scan2d());
  EXPECT_TRUE(sameTree(map.octree(), thereAndBack(map).octree()));
}

TEST(ToOctoMap, AndBackKeepsValuesBeyondTheClampingThresholds) {
  std::vector<float> values = {0.0F, 1e-4F, -1e-4F, 7.5F, -7.5F, 12.3456789F, -12.3456789F};
  std::mt19937 rng(42);
  std::uniform_real_distribution<float> wide(-20, 20);
  for (int i = 0; i < 1000; i++) values.push_back(wide(rng));
  const CProbOctoMap map = mapWithValues(values);
  EXPECT_TRUE(sameTree(map.octree(), thereAndBack(map).octree()));
}

TEST(ToOctoMap, AndBackIsExactInTheWholeDocumentedRange) {
  std::vector<float> values;
  std::mt19937 rng(43);
  std::uniform_real_distribution<double> exponent(std::log(1e-7), std::log(20.0));
  for (int i = 0; i < 2000; i++)
    values.push_back(static_cast<float>((i % 2 ? 1 : -1) * std::exp(exponent(rng))));
  const CProbOctoMap map = mapWithValues(values);
  EXPECT_TRUE(sameVoxels(voxelsOf(map.octree()), voxelsOf(thereAndBack(map).octree())));
}

TEST(ToOctoMap, GivesMrptTheSameOccupancies) {
  const CProbOctoMap map(sceneTree(0.1, 9));
  COctoMap theirs(0.7);
  map.toOctoMap(theirs);
  EXPECT_TRUE(sameVoxels(occupanciesOf(map), occupanciesOf(theirs)));
}

TEST(ToOctoMap, CarriesTheSensorModelAndOptions) {
  CProbOctoMap map(smallTree());
  auto& tree = map.octree();
  tree.setProbHit(0.81);
  tree.setProbMiss(0.29);
  tree.setClampingThresMin(0.03);
  tree.setClampingThresMax(0.98);
  tree.setOccupancyThres(0.58);
  map.insertionOptions.maxrange = 9;
  map.insertionOptions.pruning = false;
  map.likelihoodOptions.decimation = 6;
  map.renderingOptions.generateGridLines = true;
  map.genericMapParams.enableSaveAs3DObject = false;
  COctoMap theirs(0.7);
  map.toOctoMap(theirs);
  EXPECT_FLOAT_EQ(tree.getProbHitLog(), theirs.getProbHitLog());
  EXPECT_FLOAT_EQ(tree.getProbMissLog(), theirs.getProbMissLog());
  EXPECT_FLOAT_EQ(tree.getClampingThresMinLog(), theirs.getClampingThresMinLog());
  EXPECT_FLOAT_EQ(tree.getClampingThresMaxLog(), theirs.getClampingThresMaxLog());
  EXPECT_FLOAT_EQ(tree.getOccupancyThresLog(), theirs.getOccupancyThresLog());
  EXPECT_EQ(9, theirs.insertionOptions.maxrange);
  EXPECT_FALSE(theirs.insertionOptions.pruning);
  EXPECT_EQ(6U, theirs.likelihoodOptions.decimation);
  EXPECT_TRUE(theirs.renderingOptions.generateGridLines);
  EXPECT_FALSE(theirs.genericMapParams.enableSaveAs3DObject);
}

TEST(ToOctoMap, ReplacesAllThatTheTargetHeldAndWorksOnAfterwards) {
  COctoMap theirs = theirMap();
  const CProbOctoMap map(smallTree());
  map.toOctoMap(theirs);
  EXPECT_TRUE(sameVoxels(occupanciesOf(map), occupanciesOf(theirs)));
  // Its options must still reach its own tree, not that of a map that is gone.
  theirs.insertionOptions.setProbHit(0.9);
  EXPECT_FLOAT_EQ(0.9F, static_cast<float>(theirs.getProbHit()));
  theirs.updateVoxel(5, 5, 5, true);
  double p = 0;
  ASSERT_TRUE(theirs.getPointOccupancy(5, 5, 5, p));
  EXPECT_NEAR(0.9, p, 1e-6);
}

TEST(ToOctoMap, LeavesTheSourceAsItWas) {
  const CProbOctoMap map(sceneTree(0.1, 10));
  const auto before = nodesOf(map.octree());
  COctoMap theirs(0.1);
  map.toOctoMap(theirs);
  EXPECT_TRUE(sameNodes(before, nodesOf(map.octree())));
}

TEST(ToOctoMap, LogOddsWithoutAProbabilityThrowAndLeaveTheTargetAsItWas) {
  for (const float v : {40.0F, -40.0F, 1e5F, -1e5F, 100.0F, -100.0F}) {
    COctoMap theirs = theirMap();
    const auto before = occupanciesOf(theirs);
    EXPECT_ANY_THROW(mapWithValues({1.0F, v}).toOctoMap(theirs)) << v;
    EXPECT_TRUE(sameVoxels(before, occupanciesOf(theirs))) << v;
  }
}
