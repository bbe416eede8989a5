// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of CProbOctoMap with plain octrees, occupancy grids and sets of maps. */

#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap3D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/opengl/CSetOfObjects.h>

#include "support/mrpt_tools.h"
#include "support/observations.h"

using namespace map_tests;
using mrpt::maps::CMultiMetricMap;
using mrpt::maps::COccupancyGridMap3D;
using mrpt::maps::CProbOctoMap;
using mrpt::maps::CSimplePointsMap;
using mrpt::poses::CPose3D;

// ---------------------------------------------------------------- octomap::OcTree

TEST(OcTreeOfTheUsers, IsCopiedWithItsSensorModelAndLeftAsItWas) {
  auto tree = awkwardTree(0.3);
  tree->setProbHit(0.83);
  tree->setClampingThresMin(0.07);
  const octomap::OcTree& theirs = *tree;
  const auto before = nodesOf(theirs);
  CProbOctoMap map(theirs);
  EXPECT_TRUE(sameTree(theirs, map.octree()));
  EXPECT_EQ(sensorModelBits(theirs), sensorModelBits(map.octree()));
  EXPECT_EQ(theirs.getProbHit(), map.insertionOptions.probHit);
  map.clear();
  EXPECT_TRUE(sameNodes(before, nodesOf(theirs)));
}

// ---------------------------------------------------------------- COccupancyGridMap3D

namespace {

/** Returns a grid with cells of all values. Many cells are unknown. */
COccupancyGridMap3D gridOfAllValues() {
  COccupancyGridMap3D grid({-1.2, 0.4, -0.8}, {1.2, 1.6, 0.8}, 0.1F);
  std::mt19937 rng(41);
  for (size_t i = 0; i < grid.m_grid.getVoxelCount(); i++)
    *grid.m_grid.cellByIndex(i) = static_cast<COccupancyGridMap3D::voxelType>(
        rng() % 3
            ? 0
            : static_cast<int>(i % 255) + static_cast<int>(COccupancyGridMap3D::CELLTYPE_MIN));
  return grid;
}

/** Returns the known cells of a grid by the voxel of an octree at their place. */
VoxelMap cellsOf(const COccupancyGridMap3D& grid) {
  const auto& g = grid.m_grid;
  const auto voxel = [&](double min, unsigned i) {
    return static_cast<int>(std::lround(min / g.getResolutionXY())) + static_cast<int>(i);
  };
  VoxelMap cells;
  for (unsigned x = 0; x < g.getSizeX(); x++)
    for (unsigned y = 0; y < g.getSizeY(); y++)
      for (unsigned z = 0; z < g.getSizeZ(); z++)
        // cellByIndex() is wrong for grids from a stream: MRPT does not set their stride.
        if (const auto cell = g.data()[x + g.getSizeX() * (y + g.getSizeY() * z)])
          cells[{voxel(g.getXMin(), x), voxel(g.getYMin(), y), voxel(g.getZMin(), z)}] = cell;
  return cells;
}

/** Returns the log-odds of being occupied by the probabilities of MRPT. */
float logOddsOf(float cell) {
  const double freeness =
      COccupancyGridMap3D::l2p(static_cast<COccupancyGridMap3D::voxelType>(cell));
  return static_cast<float>(std::log((1 - freeness) / freeness));
}

}  // namespace

TEST(FromOccupancyGrid, GivesEachKnownCellsLogOdds) {
  const auto grid = gridOfAllValues();
  const CProbOctoMap map(grid);
  EXPECT_NEAR(0.1, map.getResolution(), 1e-7);
  const auto cells = cellsOf(grid);
  const auto voxels = voxelsOf(map.octree());
  ASSERT_GT(cells.size(), 1000U);
  ASSERT_EQ(cells.size(), voxels.size());
  for (const auto& [v, cell] : cells) {
    ASSERT_TRUE(voxels.count(v));
    const float expected = logOddsOf(cell);
    EXPECT_NEAR(expected, voxels.at(v), 1e-3 * (1 + std::abs(expected))) << cell;
    EXPECT_EQ(-cell / 16, voxels.at(v));
  }
}

TEST(FromOccupancyGrid, PutsWhatAScanHitWhereItIs) {
  COccupancyGridMap3D grid({-5, -5, -1.05}, {5, 5, 1.05}, 0.1F);
  grid.insertObservation(*scan2d());
  const CProbOctoMap map(grid);
  size_t occupied = 0;
  for (const auto& [v, log_odds] : voxelsOf(map.octree())) {
    if (log_odds <= 0) continue;
    occupied++;
    const double range = std::hypot((v[0] + 0.5) * 0.1, (v[1] + 0.5) * 0.1);
    EXPECT_GT(range, 1.9);  // the scan's wall is 2 to 4 m away
    EXPECT_LT(range, 4.1);
  }
  EXPECT_GT(occupied, 50U);
  double p = 0;
  ASSERT_TRUE(map.getPointOccupancy(1, 0, 0, p) || map.getPointOccupancy(1, 0, -0.05F, p));
  EXPECT_LT(p, 0.5);
}

TEST(FromOccupancyGrid, KeepsTheOptionsAndSensorModelOfTheMap) {
  CProbOctoMap map(0.5);
  map.insertionOptions.maxrange = 7;
  map.octree().setProbHit(0.87);
  const auto model = sensorModelBits(map.octree());
  map.fromOccupancyGrid(gridOfAllValues());
  EXPECT_EQ(model, sensorModelBits(map.octree()));
  EXPECT_EQ(7, map.insertionOptions.maxrange);
}

TEST(FromOccupancyGrid, AGridThatIsOffTheOctreesMovesByLessThanAVoxel) {
  for (const double off : {-0.049, -0.02, 0.03, 0.049}) {
    COccupancyGridMap3D grid({1 + off, off, off}, {1.5 + off, 0.5 + off, 0.5 + off}, 0.1F);
    grid.setCellFreeness(2, 1, 0, 0.1F);
    const CProbOctoMap map(grid);
    const auto voxels = voxelsOf(map.octree());
    ASSERT_EQ(1U, voxels.size());
    EXPECT_EQ((VoxelIndex{12, 1, 0}), voxels.begin()->first) << off;
  }
}

TEST(FromOccupancyGrid, CellsThatNoOctreeHoldsThrowAndChangeNothing) {
  CProbOctoMap map(smallTree());
  const auto before = nodesOf(map.octree());
  COccupancyGridMap3D flat;
  flat.m_grid.setSize(0, 1, 0, 1, 0, 1, 0.1, 0.2);
  EXPECT_ANY_THROW(map.fromOccupancyGrid(flat));
  COccupancyGridMap3D far({3276, 0, 0}, {3277, 0.2, 0.2}, 0.1F);
  EXPECT_ANY_THROW(map.fromOccupancyGrid(far));
  COccupancyGridMap3D endless({0, 0, 0}, {0.2, 0.2, 0.2}, 0.1F);
  endless.m_grid.setSize(1e300, 1e300, 0, 1, 0, 1, 0.1);
  EXPECT_ANY_THROW(map.fromOccupancyGrid(endless));
  EXPECT_TRUE(sameNodes(before, nodesOf(map.octree())));
}

TEST(ToOccupancyGrid, AndBackKeepsEveryCell) {
  const auto grid = gridOfAllValues();
  COccupancyGridMap3D back;
  CProbOctoMap(grid).toOccupancyGrid(back);
  EXPECT_TRUE(sameVoxels(cellsOf(grid), cellsOf(back)));
  EXPECT_FALSE(back.isEmpty());
}

TEST(ToOccupancyGrid, RoundsToTheNearestSixteenthWithinItsLimits) {
  CProbOctoMap map(sceneTree(0.1, 42));
  map.octree().setNodeValue(0.05, 0.05, 0.05, 0);
  putVoxel(map.octree(), {30, 0, 0}, 1e6F);
  putVoxel(map.octree(), {30, 2, 0}, -1e6F);
  putVoxel(map.octree(), {30, 4, 0}, 0.03F);  // nearer to 0 than to 1/16: unknown
  putVoxel(map.octree(), {30, 6, 0}, -0.04F);
  COccupancyGridMap3D grid;
  map.toOccupancyGrid(grid);
  VoxelMap expected;
  for (const auto& [v, log_odds] : voxelsOf(map.octree()))
    if (const float cell = std::clamp(std::round(-16 * log_odds), -127.0F, 127.0F); cell != 0)
      expected[v] = cell;
  EXPECT_TRUE(sameVoxels(expected, cellsOf(grid)));
  EXPECT_EQ(0.5F, grid.getFreenessByPos(3.05F, 0.45F, 0.05F));
  EXPECT_LT(grid.getFreenessByPos(3.05F, 0.05F, 0.05F), 0.001F);
}

TEST(ToOccupancyGrid, GivesAGridThatMrptReadsBack) {
  const CProbOctoMap map(sceneTree(0.1, 43));
  COccupancyGridMap3D grid;
  map.toOccupancyGrid(grid);
  const auto read = std::dynamic_pointer_cast<COccupancyGridMap3D>(deserialized(serialized(grid)));
  ASSERT_TRUE(read);
  EXPECT_TRUE(sameVoxels(cellsOf(grid), cellsOf(*read)));
  EXPECT_FALSE(read->isEmpty());
}

TEST(ToOccupancyGrid, OfAnEmptyMapHasNoCells) {
  auto grid = gridOfAllValues();
  CProbOctoMap(0.2).toOccupancyGrid(grid);
  EXPECT_TRUE(grid.isEmpty());
  EXPECT_EQ(0U, cellsOf(grid).size());
  EXPECT_TRUE(CProbOctoMap(grid).isEmpty());
}

TEST(ToOccupancyGrid, ABoxThatIsTooLargeThrowsAndLeavesTheTargetAsItWas) {
  auto tree = smallTree();
  putVoxel(*tree, {30000, 30000, 30000}, 1.0F);
  auto grid = gridOfAllValues();
  const auto before = cellsOf(grid);
  const MemoryLimit limit(500);
  EXPECT_NE(std::string::npos,
            errorOf([&] { CProbOctoMap(std::move(tree)).toOccupancyGrid(grid); }).find("cells"));
  EXPECT_TRUE(sameVoxels(before, cellsOf(grid)));
}

// ---------------------------------------------------------------- CMultiMetricMap

namespace {

/** Returns a set of a CProbOctoMap and a point map. */
CMultiMetricMap setOfMaps() {
  CMultiMetricMap set;
  set.maps.push_back(std::make_shared<CProbOctoMap>(0.1));
  set.maps.push_back(CSimplePointsMap::Create());
  return set;
}

}  // namespace

TEST(ProbOctoMapInASet, TakesObservationsAndTellsTheirLikelihood) {
  CMultiMetricMap set = setOfMaps();
  const CPose3D pose(0.3, -0.2, 0.1, 0.4, 0, 0);
  EXPECT_TRUE(set.isEmpty());
  ASSERT_TRUE(set.insertObservation(*scan2d(), pose));
  const auto ours = set.mapByClass<CProbOctoMap>();
  CProbOctoMap alone(0.1);
  alone.insertObservation(*scan2d(), pose);
  EXPECT_TRUE(sameTree(alone.octree(), ours->octree()));
  EXPECT_TRUE(set.canComputeObservationLikelihood(*scan2d()));
  EXPECT_NEAR(alone.computeObservationLikelihood(*scan2d(), pose) +
                  set.maps[1]->computeObservationLikelihood(*scan2d(), pose),
              set.computeObservationLikelihood(*scan2d(), pose), 1e-6);
  ours->genericMapParams.enableObservationLikelihood = false;
  EXPECT_NEAR(set.maps[1]->computeObservationLikelihood(*scan2d(), pose),
              set.computeObservationLikelihood(*scan2d(), pose), 1e-6);
  ours->genericMapParams.enableObservationInsertion = false;
  set.insertObservation(*scan2d(), CPose3D());
  EXPECT_TRUE(sameTree(alone.octree(), ours->octree()));
  set.clear();
  EXPECT_TRUE(ours->isEmpty());
}

TEST(ProbOctoMapInASet, IsSerializedAndCopiedWithoutLoss) {
  CMultiMetricMap set;
  set.maps.push_back(std::make_shared<CProbOctoMap>(awkwardTree(0.1)));
  set.maps.push_back(std::make_shared<CProbOctoMap>(sceneTree(0.2, 44)));
  const auto expectSame = [&](const CMultiMetricMap& other) {
    ASSERT_EQ(2U, other.maps.size());
    for (size_t i = 0; i < 2; i++)
      EXPECT_TRUE(sameTree(set.mapByClass<CProbOctoMap>(i)->octree(),
                           other.mapByClass<CProbOctoMap>(i)->octree()));
  };
  const auto read = std::dynamic_pointer_cast<CMultiMetricMap>(deserialized(serialized(set)));
  ASSERT_TRUE(read);
  expectSame(*read);
  const CMultiMetricMap copy(set);
  expectSame(copy);
  EXPECT_NE(set.maps[0].get(), copy.maps[0].get());
}

TEST(ProbOctoMapInASet, IsMatchedByMrptsOwnMeans) {
  CMultiMetricMap set = setOfMaps();
  set.insertObservation(*scan2d(), CPose3D());
  const auto* points = set.mapByClass<CSimplePointsMap>().get();
  EXPECT_EQ(points, set.getAsSimplePointsMap());  // a set gives its map of points, if it has one
  mrpt::maps::TMatchingRatioParams params;
  const CPose3D pose(0.1, 0, 0, 0.05, 0, 0);
  const float ours = set.maps[0]->compute3DMatchingRatio(points, pose, params);
  const float theirs = points->compute3DMatchingRatio(points, pose, params);
  EXPECT_GT(ours, 0);
  EXPECT_NEAR(0.5F * (ours + theirs), set.compute3DMatchingRatio(points, pose, params), 1e-6);
  EXPECT_NO_THROW(set.auxParticleFilterCleanUp());
}

TEST(ProbOctoMapInASet, IsDrawnAndSavedWithTheOthers) {
  CMultiMetricMap set = setOfMaps();
  set.insertObservation(*scan2d(), CPose3D());
  mrpt::opengl::CSetOfObjects scene;
  set.getVisualizationInto(scene);
  EXPECT_TRUE(scene.getByClass<mrpt::opengl::COctoMapVoxels>() ||
              scene.getByClass<mrpt::opengl::CSetOfObjects>());
  const TempDir dir;
  set.saveMetricMapRepresentationToFile(dir.path("set"));
  CProbOctoMap back(0.1);
  size_t found = 0;
  for (const auto& file : dir.files())
    if (file.size() > 3 && file.substr(file.size() - 3) == ".ot") {
      back.loadFromOcTreeFile(dir.path(file));
      found++;
    }
  ASSERT_EQ(1U, found);
  EXPECT_TRUE(sameTree(set.mapByClass<CProbOctoMap>()->octree(), back.octree()));
}
