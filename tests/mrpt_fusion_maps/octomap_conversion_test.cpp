// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the conversion of CProbOctoMap from and to the octomaps of MRPT. */

#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/maps/COctoMap.h>

#include "fusion_octree/resampling.h"
#include "support/mrpt_tools.h"
#include "support/observations.h"

using namespace map_tests;
using mrpt::maps::CColouredOctoMap;
using mrpt::maps::COctoMap;
using mrpt::maps::CProbOctoMap;
using mrpt::poses::CPose3D;

namespace {

/** Returns a map with values of many hits and misses, single voxels and pruned leaves. */
template <class Map = COctoMap>
Map theirMap() {
  Map map(0.1);
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

/** Returns the positions and sizes of the leaves as MRPT draws them. */
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

/** Returns a map of single voxels with these values, not next to each other. */
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
  // The probability of these voxels is exactly 0 or 1 in MRPT. Its log-odds are infinite, and a
  // tree with an infinity can be saved but not loaded.
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
  // Its options must belong to its own tree, not to the tree of a destroyed map.
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

// ---------------------------------------------------------------- CColouredOctoMap

namespace {

using Colour = std::array<int, 3>;
const Colour kUnset = {255, 255, 255};  // default of octomap
const Colour kRed = {200, 20, 40}, kGreen = {10, 180, 60}, kBlue = {0, 30, 240};

double coordinateOf(int voxel, double resolution = 0.1) { return (voxel + 0.5) * resolution; }

/** Returns the colour of a voxel. All channels are -1 if the voxel is unknown. */
Colour colourOf(const CColouredOctoMap& map, const VoxelIndex& v) {
  uint8_t r = 0, g = 0, b = 0;
  const auto at = [&](int axis) {
    return static_cast<float>(coordinateOf(v[axis], map.getResolution()));
  };
  if (!map.getPointColour(at(0), at(1), at(2), r, g, b)) return {-1, -1, -1};
  return {r, g, b};
}

void paint(CColouredOctoMap& map, const VoxelIndex& v, const Colour& c, bool occupied = true) {
  const double res = map.getResolution();
  const double x = coordinateOf(v[0], res), y = coordinateOf(v[1], res),
               z = coordinateOf(v[2], res);
  map.setVoxelColourMethod(CColouredOctoMap::SET);
  map.updateVoxel(x, y, z, occupied);
  map.updateVoxelColour(x, y, z, static_cast<uint8_t>(c[0]), static_cast<uint8_t>(c[1]),
                        static_cast<uint8_t>(c[2]));
}

/** Returns the voxels of a map of single voxels. */
CProbOctoMap mapOf(const std::vector<VoxelIndex>& voxels) {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  for (const auto& v : voxels) putVoxel(*tree, v, 1.5F);
  finish(*tree);
  return CProbOctoMap(std::move(tree));
}

}  // namespace

TEST(ColouredOctoMap, GivesTheOccupancyThatACOctoMapGives) {
  const CProbOctoMap expected(theirMap()), map(theirMap<CColouredOctoMap>());
  EXPECT_TRUE(sameTree(expected.octree(), map.octree()));
  EXPECT_EQ(map_tests::sensorModelBits(expected.octree()),
            map_tests::sensorModelBits(map.octree()));
  EXPECT_TRUE(CProbOctoMap(CColouredOctoMap(0.25)).isEmpty());
}

TEST(ColouredOctoMap, ThereAndBackKeepsEveryLeafBitForBit) {
  const CProbOctoMap map(sceneTree(0.1, 12));
  const auto theirs = map.toColouredOctoMap();
  EXPECT_TRUE(sameTree(map.octree(), CProbOctoMap(*theirs).octree()));
  COctoMap plain(0.1);
  map.toOctoMap(plain);
  EXPECT_TRUE(sameVoxels(occupanciesOf(plain), occupanciesOf(*theirs)));
}

TEST(ColouredOctoMap, EachVoxelTakesTheColourOfTheSourceAtItsPlace) {
  const std::vector<VoxelIndex> voxels = {{0, 0, 0}, {5, 0, 0}, {10, 0, 0}, {15, 0, 0}};
  CColouredOctoMap source(0.1);
  paint(source, voxels[0], kRed);
  paint(source, voxels[1], kGreen);
  paint(source, voxels[2], kBlue, false);  // free: not the colour of an obstacle
  source.updateVoxel(coordinateOf(15), coordinateOf(0), coordinateOf(0), true);  // without colour
  const auto coloured = mapOf(voxels).toColouredOctoMap({{source, CPose3D()}});
  EXPECT_EQ(kRed, colourOf(*coloured, voxels[0]));
  EXPECT_EQ(kGreen, colourOf(*coloured, voxels[1]));
  EXPECT_EQ(kUnset, colourOf(*coloured, voxels[2]));
  EXPECT_EQ(kUnset, colourOf(*coloured, voxels[3]));
}

TEST(ColouredOctoMap, WhereSeveralSourcesHaveAColourItIsTheirMean) {
  CColouredOctoMap a(0.1), b(0.1);
  paint(a, {0, 0, 0}, kRed);
  paint(b, {3, 0, 0}, kGreen);
  paint(b, {8, 0, 0}, kBlue);
  const auto coloured = mapOf({{0, 0, 0}, {5, 0, 0}})
                            .toColouredOctoMap({{a, CPose3D()}, {b, CPose3D(-0.3, 0, 0, 0, 0, 0)}});
  EXPECT_EQ((Colour{105, 100, 50}), colourOf(*coloured, {0, 0, 0}));
  EXPECT_EQ(kBlue, colourOf(*coloured, {5, 0, 0}));
}

TEST(ColouredOctoMap, APrunedLeafTakesTheMeanOfItsVoxels) {
  std::vector<VoxelIndex> block;
  for (int i = 0; i < 8; i++) block.push_back({i & 1, (i >> 1) & 1, i >> 2});
  CColouredOctoMap source(0.1);
  for (int i = 0; i < 4; i++) paint(source, block[i], i < 2 ? kRed : kGreen);
  const CProbOctoMap map = mapOf(block);
  ASSERT_EQ(1U, map.getNumLeafNodes());
  CProbOctoMap expanded = map;  // ours need not be pruned for it
  expanded.octree().expand();
  for (const CProbOctoMap* m : {&map, static_cast<const CProbOctoMap*>(&expanded)}) {
    const auto coloured = m->toColouredOctoMap({{source, CPose3D()}});
    for (const auto& v : block) EXPECT_EQ((Colour{105, 100, 50}), colourOf(*coloured, v));
  }
}

TEST(ColouredOctoMap, AMapThatIsTurnedAndResampledKeepsAColourAtEachVoxel) {
  for (const double resolution : {0.1, 0.17, 0.06}) {
    const CProbOctoMap map(sceneTree(0.1, 13));
    const auto source = map.toColouredOctoMap();
    for (const auto& [v, log_odds] : voxelsOf(map.octree()))
      if (log_odds >= 0) {
        const Colour& c = v[0] < 0 ? kRed : kBlue;  // of a leaf, pruned or not: all on one side
        source->setVoxelColourMethod(CColouredOctoMap::SET);
        source->updateVoxelColour(coordinateOf(v[0]), coordinateOf(v[1]), coordinateOf(v[2]),
                                  static_cast<uint8_t>(c[0]), static_cast<uint8_t>(c[1]),
                                  static_cast<uint8_t>(c[2]));
      }
    const CPose3D pose(0.53, -1.21, 0.34, 0.6, 0.1, -0.05);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = pose.getRotationMatrix().asEigen();
    T.translation() = Eigen::Vector3d(pose.x(), pose.y(), pose.z());
    const CProbOctoMap moved(mrpt::fusion::transformOcTree(map.octree(), T, resolution));
    const auto coloured = moved.toColouredOctoMap({{*source, pose}});
    size_t occupied = 0;
    for (const auto& [v, log_odds] : voxelsOf(moved.octree())) {
      if (log_odds < 0) continue;
      occupied++;
      const auto back =
          pose.inverseComposePoint({coordinateOf(v[0], resolution), coordinateOf(v[1], resolution),
                                    coordinateOf(v[2], resolution)});
      const Colour c = colourOf(*coloured, v);
      ASSERT_NE(kUnset, c) << resolution;
      if (std::abs(back.x) < 0.7) continue;  // where both colours may be near
      ASSERT_EQ(back.x < 0 ? kRed : kBlue, c) << resolution << " at " << back.x;
    }
    EXPECT_GT(occupied, 500U);
  }
}
