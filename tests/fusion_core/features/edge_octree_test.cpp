// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of edge voxels as octrees and as text. */
#include <gtest/gtest.h>
#include <mrpt/fusion/edges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "support/test_maps.h"

namespace mrpt::fusion::test::edge_octree_test {
namespace {

constexpr double kRadius = 0.5;

/** Edge voxels at some cells, each of another probability. */
EdgeVoxels edgesAt(const std::vector<Cell>& cells, double resolution = 0.1) {
  EdgeVoxels edges;
  edges.resolution = resolution;
  edges.direction_radius = kRadius;
  for (const Cell& c : cells) {
    edges.centre.push_back(centreOf(c, resolution).cast<float>());
    edges.probability.push_back(0.9F / static_cast<float>(1 + edges.probability.size()));
    edges.covariance.emplace_back();
  }
  return edges;
}

/** A line along y. */
EdgeVoxels line() { return edgesAt({{3, 0, 5}, {3, 1, 5}, {3, 2, 5}, {3, 3, 5}, {3, 4, 5}}); }

TEST(OccupancyTree, HasTheProbabilityOfEachEdgeVoxelAndNothingElse) {
  const EdgeVoxels edges = line();
  const octomap::OcTree tree = occupancyTree(edges);
  EXPECT_EQ(tree.getResolution(), 0.1);
  EXPECT_EQ(tree.getNumLeafNodes(), edges.size());
  for (size_t i = 0; i < edges.size(); i++) {
    const auto* node = tree.search(keyOf({3, static_cast<int>(i), 5}));
    ASSERT_TRUE(node) << i;
    EXPECT_NEAR(node->getOccupancy(), edges.probability[i], 1e-6) << i;
  }
}

TEST(OccupancyTree, StaysFiniteAtProbabilityOne) {
  EdgeVoxels edges = edgesAt({{0, 0, 0}});
  edges.probability[0] = 1;
  const octomap::OcTree tree = occupancyTree(edges);
  EXPECT_TRUE(std::isfinite(tree.search(keyOf({0, 0, 0}))->getLogOdds()));
  EXPECT_GT(tree.search(keyOf({0, 0, 0}))->getOccupancy(), 0.99);
}

TEST(OccupancyTree, OfNoEdgesIsEmpty) {
  const octomap::OcTree tree = occupancyTree(EdgeVoxels());
  EXPECT_EQ(tree.size(), 0U);
  EXPECT_EQ(tree.getResolution(), 0.1);
}

TEST(ProbabilityTree, KeepsEachProbabilityBitForBit) {
  EdgeVoxels edges = edgesAt({{-4, 0, 7}, {20, -9, 1}, {0, 0, 0}}, 0.25);
  edges.probability = {1, 0.1F, std::nextafter(0.7F, 1.F)};
  const EdgeVoxels read = edgesOf(probabilityTree(edges), kRadius);
  ASSERT_EQ(read.size(), edges.size());
  EXPECT_EQ(read.resolution, 0.25);
  for (size_t i = 0; i < edges.size(); i++) {  // in the octree's order
    const auto same = std::find(read.centre.begin(), read.centre.end(), edges.centre[i]);
    ASSERT_NE(same, read.centre.end()) << i;
    EXPECT_EQ(read.probability[static_cast<size_t>(same - read.centre.begin())],
              edges.probability[i]);
  }
}

TEST(EdgesOf, ComputesTheDirectionsAgain) {
  const EdgeVoxels read = edgesOf(probabilityTree(line()), kRadius);
  EXPECT_EQ(read.direction_radius, kRadius);
  ASSERT_EQ(read.covariance.size(), 5U);
  for (const EdgeCovariance& c : read.covariance) {
    EXPECT_NEAR(std::abs(c.direction().y()), 1, 1e-6);
    EXPECT_NEAR(c.linearity(), 1, 1e-6);
  }
}

TEST(EdgesOf, RefusesATreeThatIsNotOfEdgeVoxels) {
  const auto box = MapWriter().box({0, 0, 0}, {1, 1, 1}, 0.5F).pruned();  // one leaf of 8 voxels
  EXPECT_THROW(edgesOf(*box, kRadius), std::exception);
  for (const float value : {0.F, -0.5F, 1.01F})
    EXPECT_THROW(edgesOf(*MapWriter().voxel({0, 0, 0}, value).unpruned(), kRadius), std::exception)
        << value;
  EXPECT_EQ(edgesOf(*MapWriter().voxel({0, 0, 0}, 1.F).unpruned(), kRadius).size(), 1U);
}

TEST(EdgeTrees, RefuseWhatNoOctreeHolds) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto expectRefused = [](const EdgeVoxels& edges, const char* why) {
    EXPECT_THROW(occupancyTree(edges), std::exception) << why;
    EXPECT_THROW(probabilityTree(edges), std::exception) << why;
  };
  for (const float x : {4000.F, -4000.F, kNan}) {
    EdgeVoxels edges = edgesAt({{0, 0, 0}});
    edges.centre[0].x() = x;
    expectRefused(edges, "outside of the grid");
  }
  for (const float p : {0.F, -0.1F, 1.1F, kNan}) {
    EdgeVoxels edges = edgesAt({{0, 0, 0}});
    edges.probability[0] = p;
    expectRefused(edges, "no probability");
  }
  for (const double resolution : {0.0, -0.1, std::numeric_limits<double>::infinity()}) {
    EdgeVoxels edges = edgesAt({{0, 0, 0}});
    edges.resolution = resolution;
    expectRefused(edges, "no length");
  }
}

TEST(ToPly, HasALineOfEightNumbersForEachEdgeVoxel) {
  EdgeVoxels edges = edgesAt({{3, 0, 5}, {3, 1, 5}});
  edges.covariance[0].eigenvalues = {0, 0, 2};
  edges.covariance[0].eigenvectors << 1, 0, 0, 0, 0, 1, 0, 1, 0;  // tau: y
  std::istringstream ply(toPly(edges));
  std::string line_of_text;
  std::getline(ply, line_of_text);
  EXPECT_EQ(line_of_text, "ply");
  bool has_count = false;
  int properties = 0;
  while (std::getline(ply, line_of_text) && line_of_text != "end_header") {
    has_count |= line_of_text == "element vertex 2";
    properties += line_of_text.rfind("property float ", 0) == 0;
  }
  EXPECT_TRUE(has_count);
  EXPECT_EQ(properties, 8);
  std::vector<double> numbers;
  for (double x; ply >> x;) numbers.push_back(x);
  ASSERT_EQ(numbers.size(), 16U);
  const double expected[] = {0.35, 0.05, 0.55, 0, 1, 0, 0.9, 1};
  for (size_t i = 0; i < 8; i++) EXPECT_NEAR(numbers[i], expected[i], 1e-5) << i;
  EXPECT_TRUE(ply.eof());
}

TEST(ToPly, OfNoEdgesIsAHeader) {
  const std::string ply = toPly(EdgeVoxels());
  EXPECT_NE(ply.find("element vertex 0\n"), std::string::npos);
  EXPECT_EQ(ply.substr(ply.size() - 11), "end_header\n");
}

}  // namespace
}  // namespace mrpt::fusion::test::edge_octree_test
