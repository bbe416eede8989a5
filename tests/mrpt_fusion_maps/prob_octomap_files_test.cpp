// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the drawings and the octree files of CProbOctoMap. */

#include <mrpt/maps/COctoMap.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/opengl/CSetOfObjects.h>

#include "support/mrpt_tools.h"
#include "support/observations.h"

using namespace map_tests;
using mrpt::maps::COctoMap;
using mrpt::maps::CProbOctoMap;
using mrpt::opengl::COctoMapVoxels;

namespace {

/** A drawn cube: position, size and colour. */
using DrawnVoxel = std::tuple<float, float, float, float, int, int, int, int>;

std::vector<DrawnVoxel> drawnVoxels(const COctoMapVoxels& gl, size_t set) {
  std::vector<DrawnVoxel> drawn;
  for (size_t i = 0; i < gl.getVoxelCount(set); i++) {
    const auto& v = gl.getVoxel(set, i);
    drawn.emplace_back(v.coords.x, v.coords.y, v.coords.z, v.side_length, v.color.R, v.color.G,
                       v.color.B, v.color.A);
  }
  return drawn;
}

template <class Map>
COctoMapVoxels drawn(const Map& map,
                     COctoMapVoxels::visualization_mode_t mode = COctoMapVoxels::FIXED) {
  COctoMapVoxels gl;
  gl.setColor(0.9F, 0.8F, 0.4F, 0.7F);
  gl.setVisualizationMode(mode);
  map.getAsOctoMapVoxels(gl);
  return gl;
}

void expectSameDrawing(const COctoMapVoxels& a, const COctoMapVoxels& b) {
  ASSERT_EQ(a.getVoxelSetCount(), b.getVoxelSetCount());
  for (size_t set = 0; set < a.getVoxelSetCount(); set++) {
    EXPECT_EQ(a.areVoxelsVisible(set), b.areVoxelsVisible(set));
    const auto va = drawnVoxels(a, set), vb = drawnVoxels(b, set);
    ASSERT_EQ(va.size(), vb.size());
    for (size_t i = 0; i < va.size(); i++)
      ASSERT_EQ(va[i], vb[i]) << "set " << set << " voxel " << i;
  }
  ASSERT_EQ(a.getGridCubeCount(), b.getGridCubeCount());
  for (size_t i = 0; i < a.getGridCubeCount(); i++) {
    // COctoMap takes the corners from a centre that it has rounded to float.
    ASSERT_LT((a.getGridCube(i).min - b.getGridCube(i).min).norm(), 1e-3);
    ASSERT_LT((a.getGridCube(i).max - b.getGridCube(i).max).norm(), 1e-3);
  }
  const auto box_a = a.getBoundingBox(), box_b = b.getBoundingBox();
  EXPECT_EQ(box_a.min, box_b.min);
  EXPECT_EQ(box_a.max, box_b.max);
}

/** A COctoMap and a CProbOctoMap with the same tree. */
struct Twins {
  COctoMap theirs{0.1};
  CProbOctoMap ours{0.1};

  Twins() {
    std::mt19937 rng(21);
    std::uniform_real_distribution<double> place(-1, 1);
    for (int i = 0; i < 4000; i++) {
      const double x = place(rng), y = place(rng), z = 0.5 * place(rng);
      const bool occupied = z < 0.1;
      theirs.updateVoxel(x, y, z, occupied);
      ours.updateVoxel(x, y, z, occupied);
    }
  }
};

}  // namespace

// ---------------------------------------------------------------- drawing

TEST(ProbOctoMapDrawing, GivesOneObjectWithAVoxelForEachLeaf) {
  const CProbOctoMap map(sceneTree(0.1, 4));
  mrpt::opengl::CSetOfObjects objects;
  map.getVisualizationInto(objects);
  ASSERT_EQ(1U, objects.size());
  const auto gl = objects.getByClass<COctoMapVoxels>();
  ASSERT_TRUE(gl);
  size_t occupied = 0, free = 0;
  for (auto it = map.octree().begin_leafs(); it != map.octree().end_leafs(); ++it)
    (map.octree().isNodeOccupied(*it) ? occupied : free)++;
  ASSERT_GT(occupied, 100U);
  ASSERT_GT(free, 100U);
  EXPECT_EQ(occupied, gl->getVoxelCount(mrpt::opengl::VOXEL_SET_OCCUPIED));
  EXPECT_EQ(free, gl->getVoxelCount(mrpt::opengl::VOXEL_SET_FREESPACE));
}

TEST(ProbOctoMapDrawing, IsCOctoMapsInEveryColouringScheme) {
  const Twins twins;
  for (const auto mode :
       {COctoMapVoxels::FIXED, COctoMapVoxels::COLOR_FROM_HEIGHT,
        COctoMapVoxels::COLOR_FROM_OCCUPANCY, COctoMapVoxels::TRANSPARENCY_FROM_OCCUPANCY,
        COctoMapVoxels::TRANS_AND_COLOR_FROM_OCCUPANCY, COctoMapVoxels::MIXED}) {
    SCOPED_TRACE(mode);
    expectSameDrawing(drawn(twins.theirs, mode), drawn(twins.ours, mode));
  }
}

TEST(ProbOctoMapDrawing, FollowsTheRenderingOptionsAsCOctoMapDoes) {
  Twins twins;
  for (unsigned bits = 0; bits < 32; bits++) {
    SCOPED_TRACE(bits);
    auto& o = twins.ours.renderingOptions;
    o.generateGridLines = bits & 1;
    o.generateOccupiedVoxels = bits & 2;
    o.visibleOccupiedVoxels = bits & 4;
    o.generateFreeVoxels = bits & 8;
    o.visibleFreeVoxels = bits & 16;
    twins.theirs.renderingOptions = o;
    expectSameDrawing(drawn(twins.theirs), drawn(twins.ours));
  }
}

TEST(ProbOctoMapDrawing, OfAnEmptyMapHasNoVoxels) {
  const auto gl = drawn(CProbOctoMap(0.1));
  EXPECT_EQ(0U, gl.getVoxelCount(mrpt::opengl::VOXEL_SET_OCCUPIED));
  EXPECT_EQ(0U, gl.getVoxelCount(mrpt::opengl::VOXEL_SET_FREESPACE));
}

TEST(ProbOctoMapDrawing, CanBeSwitchedOff) {
  CProbOctoMap map(smallTree());
  mrpt::opengl::CSetOfObjects objects;
  map.genericMapParams.enableSaveAs3DObject = false;
  map.getVisualizationInto(objects);
  EXPECT_EQ(0U, objects.size());
  map.genericMapParams.enableSaveAs3DObject = true;
  map.getVisualizationInto(objects);
  EXPECT_EQ(1U, objects.size());
}

// ---------------------------------------------------------------- files

TEST(ProbOctoMapFiles, TheMapsRepresentationIsASceneAndATreeThatReopen) {
  const TempDir dir;
  const CProbOctoMap map(sceneTree(0.1, 5));
  map.saveMetricMapRepresentationToFile(dir.path("robot"));
  EXPECT_EQ((std::vector<std::string>{"robot.ot", "robot_3D.3Dscene"}), dir.files());

  CProbOctoMap tree(0.5);
  tree.loadFromOcTreeFile(dir.path("robot.ot"));
  EXPECT_TRUE(sameTree(map.octree(), tree.octree()));

  mrpt::opengl::COpenGLScene scene;
  ASSERT_TRUE(scene.loadFromFile(dir.path("robot_3D.3Dscene")));
  const auto gl = scene.getByClass<COctoMapVoxels>();
  ASSERT_TRUE(gl);
  COctoMapVoxels direct;
  map.getAsOctoMapVoxels(direct);
  expectSameDrawing(direct, *gl);
}

TEST(ProbOctoMapFiles, ARepresentationThatCannotBeWrittenThrows) {
  const TempDir dir;
  EXPECT_ANY_THROW(CProbOctoMap(smallTree())
                       .saveMetricMapRepresentationToFile(dir.path("no_such_directory/robot")));
}

TEST(ProbOctoMapFiles, TheExtensionSaysWhetherProbabilitiesAreSaved) {
  const TempDir dir;
  const CProbOctoMap map(sceneTree(0.1, 6));
  map.saveToOcTreeFile(dir.path("map.ot"));
  map.saveToOcTreeFile(dir.path("map.bt"));
  EXPECT_EQ(mrpt::fusion::toOtFile(map.octree()), readRaw(dir.path("map.ot")));
  EXPECT_EQ(mrpt::fusion::toBtFile(map.octree()), readRaw(dir.path("map.bt")));
}

TEST(ProbOctoMapFiles, LoadingGoesByContentAndTakesTheSensorModel) {
  const TempDir dir;
  const CProbOctoMap map(sceneTree(0.1, 7));
  map.saveToOcTreeFile(dir.path("map.ot"));
  std::filesystem::rename(dir.path("map.ot"), dir.path("map.bt"));
  CProbOctoMap loaded(0.5);
  loaded.insertionOptions.probHit = 0.9;
  loaded.insertionOptions.maxrange = 4;
  loaded.loadFromOcTreeFile(dir.path("map.bt"));
  EXPECT_TRUE(sameTree(map.octree(), loaded.octree()));
  EXPECT_EQ(loaded.octree().getProbHit(), loaded.insertionOptions.probHit);
  EXPECT_EQ(4, loaded.insertionOptions.maxrange);
}

TEST(ProbOctoMapFiles, BytesAreThoseOfFiles) {
  const TempDir dir;
  const CProbOctoMap map(sceneTree(0.1, 8));
  map.saveToOcTreeFile(dir.path("map.ot"));
  map.saveToOcTreeFile(dir.path("map.bt"));
  EXPECT_EQ(readRaw(dir.path("map.ot")), map.toOtBytes());
  EXPECT_EQ(readRaw(dir.path("map.bt")), map.toBtBytes());
  CProbOctoMap loaded(0.5);
  loaded.loadFromOcTreeBytes(map.toOtBytes());
  EXPECT_TRUE(sameTree(map.octree(), loaded.octree()));

  const std::string file = map.toOtBytes(), nodes = file.substr(file.find("data\n") + 5);
  CProbOctoMap of_nodes;
  of_nodes.loadFromOcTreeBytes(nodes, 0.1);
  EXPECT_TRUE(sameNodes(nodesOf(map.octree()), nodesOf(of_nodes.octree())));
  for (const std::string& bad : {nodes, std::string(), file.substr(0, file.size() / 2)}) {
    EXPECT_THROW(loaded.loadFromOcTreeBytes(bad), std::runtime_error);
    EXPECT_TRUE(sameTree(map.octree(), loaded.octree())) << "as before";
  }
  EXPECT_THROW(loaded.loadFromOcTreeBytes(nodes + "x", 0.1), std::runtime_error);
}

TEST(ProbOctoMapFiles, AFileThatCannotBeReadOrWrittenIsNamedInTheError) {
  const TempDir dir;
  CProbOctoMap map(sceneTree(0.1, 8));
  const auto before = nodesOf(map.octree());
  writeRaw(dir.path("bad.ot"), "hello\n");
  for (const char* name : {"bad.ot", "missing.ot"}) {
    const std::string error = errorOf([&] { map.loadFromOcTreeFile(dir.path(name)); });
    EXPECT_EQ(0U, error.find(dir.path(name) + ": ")) << error;
    EXPECT_TRUE(sameNodes(before, nodesOf(map.octree())));
  }
  for (const char* name : {"none/map.ot", "none/map.bt"}) {
    const std::string error = errorOf([&] { map.saveToOcTreeFile(dir.path(name)); });
    EXPECT_EQ(0U, error.find(dir.path(name) + ": ")) << error;
  }
}

TEST(ProbOctoMapFiles, ItsTextSaysResolutionAndSize) {
  const CProbOctoMap map(smallTree());
  EXPECT_NE(std::string::npos, map.asString().find("0.100"));
  EXPECT_NE(std::string::npos, map.asString().find(std::to_string(map.size())));
}
