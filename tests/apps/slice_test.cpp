// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of `map-fusion slice`. */

#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/serialization/CArchive.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "run.h"

namespace {

using mrpt::maps::COccupancyGridMap2D;

class Slices : public AppTest {
 protected:
  /** Returns the highest probability of each column of the map, between two heights. */
  static std::map<std::pair<int, int>, double> columns(double low, double high) {
    std::unique_ptr<octomap::OcTree> map(
        dynamic_cast<octomap::OcTree*>(octomap::AbstractOcTree::read(pair("map_a.ot"))));
    map->expand();
    std::map<std::pair<int, int>, double> columns;
    for (auto leaf = map->begin_leafs(); leaf != map->end_leafs(); ++leaf) {
      if (leaf.getZ() < low || leaf.getZ() > high) continue;
      double& column = columns[{leaf.getKey()[0] - 32768, leaf.getKey()[1] - 32768}];
      column = std::max(column, leaf->getOccupancy());
    }
    return columns;
  }
  /** Calls `f(column, cell)` for each cell of a grid with the expected probability of the column,
   * or null if it is unknown, and the probability of the cell. */
  template <class F>
  static void forEachCell(const COccupancyGridMap2D& grid, double low, double high, F&& f) {
    const auto expected = columns(low, high);
    EXPECT_GT(expected.size(), 1000U);
    EXPECT_GE(size_t{grid.getSizeX()} * grid.getSizeY(), expected.size());
    const double side = grid.getResolution();
    EXPECT_NEAR(side, 0.1, 1e-6);
    const auto first_x = static_cast<int>(std::lround(grid.getXMin() / side));
    const auto first_y = static_cast<int>(std::lround(grid.getYMin() / side));
    size_t known = 0;
    for (int y = 0; y < static_cast<int>(grid.getSizeY()); y++)
      for (int x = 0; x < static_cast<int>(grid.getSizeX()); x++) {
        const auto column = expected.find({first_x + x, first_y + y});
        known += column != expected.end();
        f(column == expected.end() ? nullptr : &column->second, 1 - grid.getCell(x, y));
      }
    EXPECT_EQ(known, expected.size());
  }
  /** The grid of ROS has three kinds of cells. */
  static void expectKinds(const COccupancyGridMap2D& grid, double low, double high) {
    forEachCell(grid, low, high, [](const double* column, double cell) {
      const double expected = !column ? 0.5 : *column >= 0.5 ? 1 : 0;
      ASSERT_NEAR(cell, expected, 0.02);
    });
  }
  /** The grid of MRPT has probabilities. Its cells have 8 bits. */
  static void expectProbabilities(const COccupancyGridMap2D& grid, double low, double high) {
    forEachCell(grid, low, high, [](const double* column, double cell) {
      ASSERT_NEAR(cell, column ? *column : 0.5, column ? 0.02 : 1e-6);
    });
  }
  COccupancyGridMap2D readGrid(const std::string& file) const {
    mrpt::io::CFileGZInputStream in((dir_ / file).string());
    COccupancyGridMap2D grid;
    mrpt::serialization::archiveFrom(in) >> grid;
    return grid;
  }
};

TEST_F(Slices, AreReadByMrptAsMapsOfRos) {
  const auto r =
      mapFusion("slice " + pair("map_a.ot") + " --heights 0.3 1.2 -o map.pgm --json report.json");
  ASSERT_EQ(r.code, 0) << r.err;
  COccupancyGridMap2D grid;
  ASSERT_TRUE(grid.loadFromROSMapServerYAML((dir_ / "map.yaml").string()));
  expectKinds(grid, 0.3, 1.2);
  const auto report = nlohmann::json::parse(readFile(dir_ / "report.json")).at("slice");
  EXPECT_EQ(report.at("width"), grid.getSizeX());
  EXPECT_EQ(report.at("height"), grid.getSizeY());
  const auto expected = columns(0.3, 1.2);
  const auto occupied = std::count_if(expected.begin(), expected.end(),
                                      [](const auto& column) { return column.second >= 0.5; });
  EXPECT_EQ(report.at("occupied"), occupied);
  EXPECT_EQ(report.at("free"), expected.size() - static_cast<size_t>(occupied));
  EXPECT_NE(r.out.find("cells:"), std::string::npos) << r.out;
}

TEST_F(Slices, AreGridsOfMrpt) {
  for (const std::string file : {"map.gridmap", "map.gridmap.gz"}) {
    const auto r = mapFusion("slice " + pair("map_a.ot") + " --heights 0.3 1.2 -o " + file);
    ASSERT_EQ(r.code, 0) << r.err;
    expectProbabilities(readGrid(file), 0.3, 1.2);
  }
  EXPECT_LT(fs::file_size(dir_ / "map.gridmap.gz"), fs::file_size(dir_ / "map.gridmap"));
}

TEST_F(Slices, HaveAllHeightsWithoutOption) {
  ASSERT_EQ(mapFusion("slice " + pair("map_a.ot") + " -o map.gridmap").code, 0);
  expectProbabilities(readGrid("map.gridmap"), -1e9, 1e9);
}

TEST_F(Slices, HaveThresholds) {
  const auto unknown = [&](const std::string& options) {
    const auto r =
        mapFusion("slice " + pair("map_a.ot") + options + " -o t.pgm --json report.json");
    EXPECT_EQ(r.code, 0) << r.err;
    return nlohmann::json::parse(readFile(dir_ / "report.json"))
        .at("slice")
        .at("unknown")
        .get<int>();
  };
  EXPECT_LT(unknown(""), unknown(" --thresholds 0.25 0.65"));
  EXPECT_EQ(unknown(""), unknown(" --thresholds 0.5 0.5"));
}

TEST_F(Slices, OfWrongArgumentsAreUsageErrors) {
  const std::string slice = "slice " + pair("map_a.ot") + " ";
  for (const std::string arguments :
       {"-o map.png", "-o map", "-o -", "-o map.pgm.gz", "-o map.pgm --heights 1",
        "-o map.pgm --heights 2 1", "-o map.pgm --heights nan 1", "-o map.pgm --thresholds 0.6 0.5",
        "-o map.pgm --thresholds 0.6 1.5", "-o map.pgm --json map.yaml"}) {
    const auto r = mapFusion(slice + arguments);
    EXPECT_EQ(r.code, 2) << arguments << "\n" << r.err;
    EXPECT_FALSE(fs::exists(dir_ / "map.pgm")) << arguments;
    EXPECT_FALSE(fs::exists(dir_ / "map.yaml")) << arguments;
  }
}

TEST_F(Slices, OfBadInputGiveOneLineAndNoFile) {
  const auto expectLine = [&](const std::string& arguments, const std::string& reason) {
    const auto r = mapFusion("slice " + arguments);
    EXPECT_EQ(r.code, 1) << arguments;
    EXPECT_NE(r.err.find(reason), std::string::npos) << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    EXPECT_FALSE(fs::exists(dir_ / "map.pgm")) << arguments;
    EXPECT_FALSE(fs::exists(dir_ / "map.yaml")) << arguments;
  };
  expectLine(pair("map_a.ot") + " --heights 500 600 -o map.pgm", "no voxel between these heights");
  expectLine("missing.ot -o map.pgm", "missing.ot");
  ASSERT_EQ(mapFusion("edges " + pair("map_a.ot") + " -o edges.gz").code, 0);
  expectLine("edges.gz -o map.pgm", "edges alone");
  fs::create_directory(dir_ / "there");
  fs::create_directory(dir_ / "there" / "m.yaml");
  expectLine(pair("map_a.ot") + " -o there/m.pgm", "is a directory");
  EXPECT_FALSE(fs::exists(dir_ / "there" / "m.pgm"));
}

}  // namespace
