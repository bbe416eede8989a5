// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the insertion of scans: each octree is compared with the octree of octomap, node by node
 * and bit by bit. */
#include "fusion_octree/insertion/scan_insertion.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "support/tree_tools.h"

namespace mrpt::fusion {
namespace {

using map_tests::nodesOf;
using map_tests::sameTree;
using octomap::OcTree;
using octomap::point3d;
using Ends = std::vector<point3d>;

/** Inserts a scan as octomap does. */
void insertWithOctomap(OcTree& tree, const Ends& ends, const point3d& origin, double max_range,
                       bool prune) {
  octomap::Pointcloud cloud;
  for (const auto& end : ends) cloud.push_back(end);
  tree.insertPointCloud(cloud, origin, max_range, true);
  tree.updateInnerOccupancy();
  if (prune) tree.prune();
}

/** Two octrees that get the same scans: from octomap and from the code under test. */
struct Twins {
  explicit Twins(double resolution) : expected(resolution), tree(resolution) {}
  explicit Twins(const OcTree& before)
      : expected(before), tree(before), inner_nodes(InnerNodes::Unknown) {}

  void insert(const Ends& ends, const point3d& origin, double max_range = -1, bool prune = true) {
    insertWithOctomap(expected, ends, origin, max_range, prune);
    inner_nodes = insertScan(tree, ends, origin, max_range, prune, inner_nodes);
  }
  testing::AssertionResult same() const {
    if (expected.size() != tree.size() || tree.size() != tree.calcNumNodes())
      return testing::AssertionFailure() << "sizes " << expected.size() << ", " << tree.size()
                                         << ", counted " << tree.calcNumNodes();
    return sameTree(expected, tree);
  }

  OcTree expected, tree;
  InnerNodes inner_nodes = InnerNodes::Pruned;
};

/** Makes random scans. */
class Scans {
 public:
  explicit Scans(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  template <class T>
  T oneOf(const std::vector<T>& choices) {
    return choices[std::uniform_int_distribution<size_t>(0, choices.size() - 1)(random_)];
  }
  /** Returns a point in a box of this size. \param[in] grid Multiple to which the coordinates are
   * rounded; 0: none. */
  point3d point(double size, double grid = 0) {
    point3d p;
    for (unsigned axis = 0; axis < 3; axis++) {
      const double x = uniform(-size, size);
      p(axis) = static_cast<float>(grid > 0 ? std::round(x / grid) * grid : x);
    }
    return p;
  }
  Ends ends(size_t count, double size, double grid = 0) {
    Ends ends(count);
    for (auto& end : ends) end = point(size, grid);
    return ends;
  }
  /** Returns the walls of a room, seen densely. */
  Ends room(size_t count, double size) {
    Ends ends(count);
    for (auto& end : ends) {
      end = point(size);
      end(oneOf<unsigned>({0, 0, 1, 1, 2})) = static_cast<float>(oneOf<double>({-size, size}));
    }
    return ends;
  }

 private:
  std::mt19937 random_;
};

TEST(ScanInsertion, GivesTheOctreeOfOctomapForRandomScans) {
  for (unsigned seed = 0; seed < 60; seed++) {
    Scans scans(seed);
    const double resolution = scans.oneOf<double>({0.05, 0.1, 0.37});
    Twins twins(resolution);
    const bool prune = seed % 4 != 0;
    for (int scan = 0; scan < 3; scan++) {
      const auto count = scans.oneOf<size_t>({0, 1, 7, 300, 2000});
      const double size = scans.oneOf<double>({0.08, 1, 4});
      // On a grid, many ends lie on borders of voxels, and many distances are equal.
      const double grid = scans.oneOf<double>({0, 0, resolution, 0.5 * resolution, 1});
      Ends ends = scans.ends(count, size, grid);
      if (count > 3) {
        ends[1] = ends[0];                                         // the same end twice
        ends[2] = point3d(ends[0].x(), ends[1].y(), ends[3].z());  // parallel to an axis
      }
      const point3d origin = scans.point(scans.oneOf<double>({0, 1, 9}), grid);
      if (count > 1) ends.push_back(origin);  // no length
      const double max_range = scans.oneOf<double>({-1, -1, 0, 0.2, 1.5, 100});
      twins.insert(ends, origin, max_range, prune);
      ASSERT_TRUE(twins.same()) << "seed " << seed << ", scan " << scan;
    }
  }
}

TEST(ScanInsertion, GivesTheOctreeOfOctomapForDenseScansUntilAllVoxelsAreAtTheirLimits) {
  Scans scans(1);
  Twins twins(0.1);
  for (int scan = 0; scan < 14; scan++) {
    twins.insert(scans.room(6000, 1.6), scans.point(scan < 10 ? 0.02 : 1));
    ASSERT_TRUE(twins.same()) << scan;
  }
  size_t large_leaves = 0;
  for (auto leaf = twins.tree.begin_leafs(); leaf != twins.tree.end_leafs(); ++leaf)
    large_leaves += leaf.getDepth() < 16;
  EXPECT_GT(large_leaves, 20U) << "leaves are pruned, expanded and pruned again";
}

TEST(ScanInsertion, TheSensorModelMayBeUnusual) {
  struct Model {
    double hit, miss, low, high;
  };
  for (const auto& m : {Model{0.5, 0.5, 0.1, 0.9}, Model{0.9, 0.1, 0.45, 0.55},
                        Model{0.7, 0.4, 0.6, 0.9}, Model{0.7, 0.4, 0.1, 0.3}}) {
    Scans scans(2);
    OcTree empty(0.1);
    empty.setProbHit(m.hit);
    empty.setProbMiss(m.miss);
    empty.setClampingThresMin(m.low);
    empty.setClampingThresMax(m.high);
    for (const bool prune : {true, false}) {
      Twins twins(empty);
      for (int scan = 0; scan < 5; scan++) {
        twins.insert(scans.room(1500, 1), scans.point(0.3), -1, prune);
        ASSERT_TRUE(twins.same()) << m.hit << " " << m.low << " " << prune << " scan " << scan;
      }
    }
  }
}

TEST(ScanInsertion, EndsMayBeOutsideOfTheGridAndNoNumbers) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Scans scans(3);
  for (const double max_range : {-1.0, 2.0}) {
    Twins twins(0.1);
    Ends ends = scans.ends(300, 3);
    for (unsigned axis = 0; axis < 3; axis++)
      for (const float bad : {kNan, 1e10F, -1e38F, 3276.85F, -3276.85F}) {
        ends[axis * 90 + ends.size() % 7] = scans.point(1);
        ends.push_back(scans.point(1));
        ends.back()(axis) = bad;
      }
    twins.insert(ends, scans.point(1), max_range);
    ASSERT_TRUE(twins.same()) << max_range;
    twins.insert(ends, point3d(0, 4000, 0), max_range);  // origin outside: hits, but no free voxels
    ASSERT_TRUE(twins.same()) << max_range;
    twins.insert(ends, point3d(0, 0, kNan), max_range);
    ASSERT_TRUE(twins.same()) << max_range;
    twins.insert({{kNan, 0, 0}}, point3d(0, 0, 0), max_range);
    ASSERT_TRUE(twins.same()) << max_range;
  }
  Twins empty(0.1);
  empty.insert({{kNan, 0, 0}}, point3d(0, 0, 0));
  EXPECT_EQ(empty.tree.getRoot(), nullptr);
  EXPECT_TRUE(empty.same());
}

TEST(ScanInsertion, RaysMayRunAlongTheBorderOfTheGrid) {
  Scans scans(4);
  for (const float border : {3276.8F, -3276.8F}) {
    Twins twins(0.1);
    for (int scan = 0; scan < 3; scan++) {
      const point3d corner(border, scan > 0 ? border : 0, scan > 1 ? -border : 0);
      Ends ends = scans.ends(400, 1);
      for (auto& end : ends) end = corner + end;
      twins.insert(ends, corner + point3d(-0.4F * (border > 0 ? 1.F : -1.F), 0.05F, 0.05F));
      ASSERT_TRUE(twins.same()) << border << " " << scan;
    }
  }
}

TEST(ScanInsertion, RaysMayBeLong) {
  Scans scans(5);
  Twins twins(0.1);
  twins.insert(scans.ends(40, 100), scans.point(1));
  ASSERT_TRUE(twins.same());
  twins.insert(scans.ends(4, 3000), scans.point(1));  // too large for a window of voxels
  ASSERT_TRUE(twins.same());
}

TEST(ScanInsertion, TheOctreeMayComeFromElsewhere) {
  Scans scans(6);
  std::vector<std::unique_ptr<OcTree>> trees;
  trees.push_back(map_tests::awkwardTree(0.1));
  trees.push_back(map_tests::sceneTree(0.1, 3));
  trees.push_back(std::make_unique<OcTree>(0.1));  // one leaf: the whole grid
  OcTreeAccess::createRoot(*trees.back())->setLogOdds(0.4F);
  trees.push_back(std::make_unique<OcTree>(0.1));  // equal leaves that are not pruned
  insertWithOctomap(*trees.back(), scans.room(3000, 1), point3d(0, 0, 0), -1, false);
  trees.push_back(std::make_unique<OcTree>(*trees.back()));  // inner nodes that are not current
  for (auto node = trees.back()->begin_tree(); node != trees.back()->end_tree(); ++node)
    if (!node.isLeaf()) node->setLogOdds(7);
  for (size_t i = 0; i < trees.size(); i++)
    for (const bool prune : {true, false}) {
      Twins twins(*trees[i]);
      for (int scan = 0; scan < 4; scan++) {
        twins.insert(scans.room(800, 2), scans.point(0.5), -1, prune != (scan == 2));
        ASSERT_TRUE(twins.same()) << "tree " << i << ", scan " << scan;
      }
    }
}

TEST(ScanInsertion, LargeLeavesAreExpandedIfTheirVoxelsChange) {
  Scans scans(11);
  for (const unsigned depth : {1U, 3U, 9U, 11U, 12U, 13U, 14U, 15U})
    for (const float log_odds : {-2.0F, -0.4F, 0.3F, 3.5F})  // at and between the limits
      for (const bool prune : {true, false}) {
        OcTree tree(0.1);
        map_tests::putLeaf(tree, {0, 0, 0}, depth, log_odds);
        map_tests::putLeaf(tree, {-1, -1, -1}, depth, log_odds);
        Twins twins(tree);
        for (OcTree* one : {&twins.expected, &twins.tree})
          twins.inner_nodes = finishLazyUpdates(*one, prune, InnerNodes::Unknown);
        for (int scan = 0; scan < 3; scan++) {
          twins.insert(scans.room(1000, 1), scans.point(0.4), -1, prune);
          ASSERT_TRUE(twins.same()) << "depth " << depth << ", " << log_odds << ", scan " << scan;
        }
      }
}

TEST(ScanInsertion, LeavesWithoutANumberStay) {
  for (const float odd : {std::numeric_limits<float>::quiet_NaN(), -0.F, 50.F, -50.F}) {
    Scans scans(7);
    OcTree before(0.1);
    before.setClampingThresMax(0.999);
    insertWithOctomap(before, scans.room(3000, 1.2), point3d(0, 0, 0), -1, true);
    for (auto leaf = before.begin_leafs(); leaf != before.end_leafs(); ++leaf)
      if (leaf.getDepth() < 16) leaf->setLogOdds(odd);
    Twins twins(before);
    for (OcTree* tree : {&twins.expected, &twins.tree})
      twins.inner_nodes = finishLazyUpdates(*tree, true, InnerNodes::Unknown);
    EXPECT_EQ(twins.inner_nodes, InnerNodes::Pruned);
    for (int scan = 0; scan < 3; scan++) {
      twins.insert(scans.room(3000, 1.2), scans.point(0.1));
      ASSERT_TRUE(twins.same()) << odd << " " << scan;
    }
  }
}

TEST(ScanInsertion, TheNumberOfThreadsMakesNoDifference) {
  std::vector<std::vector<map_tests::NodeRecord>> nodes;
  for (const size_t threads : {1U, 2U, 4U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Scans scans(8);
    OcTree tree(0.05);
    auto known = InnerNodes::Pruned;
    for (int scan = 0; scan < 4; scan++)
      known = insertScan(tree, scans.room(9000, 2), scans.point(0.4), -1, true, known);
    nodes.push_back(nodesOf(tree));
  }
  ASSERT_GT(nodes[0].size(), 10000U);
  EXPECT_TRUE(nodes[1] == nodes[0]);
  EXPECT_TRUE(nodes[2] == nodes[0]);
}

TEST(ScanInsertion, ObeysTheBoundingBoxAndRecordsChanges) {
  Scans scans(9);
  Twins boxed(0.1);
  for (OcTree* tree : {&boxed.expected, &boxed.tree}) {
    tree->useBBXLimit(true);
    point3d low(-1, -1, -1), high(1, 1, 0.5F);
    tree->setBBXMin(low);
    tree->setBBXMax(high);
  }
  Twins recorded(0.1);
  recorded.expected.enableChangeDetection(true);
  recorded.tree.enableChangeDetection(true);
  for (int scan = 0; scan < 3; scan++) {
    const Ends ends = scans.ends(500, 2);
    for (Twins* twins : {&boxed, &recorded}) {
      twins->insert(ends, point3d(0.1F, 0, 0));
      ASSERT_TRUE(twins->same());
    }
  }
  EXPECT_EQ(recorded.tree.numChangesDetected(), recorded.expected.numChangesDetected());
  EXPECT_GT(recorded.tree.numChangesDetected(), 0U);
}

TEST(ScanInsertion, KnowsWhetherAllLeavesArePruned) {
  Scans scans(10);
  const Ends ends = scans.room(2000, 1);
  const auto insertInto = [&](OcTree& tree, bool prune, InnerNodes known) {
    return insertScan(tree, ends, point3d(0, 0, 0), -1, prune, known);
  };
  OcTree tree(0.1);
  EXPECT_EQ(insertInto(tree, true, InnerNodes::Pruned), InnerNodes::Pruned);
  EXPECT_EQ(insertInto(tree, false, InnerNodes::Pruned), InnerNodes::Current);
  EXPECT_EQ(insertInto(tree, true, InnerNodes::Current), InnerNodes::Pruned);
  EXPECT_EQ(insertInto(tree, true, InnerNodes::Unknown), InnerNodes::Pruned);

  // octomap does not prune these 8 leaves: at the depth below there is nothing to prune.
  OcTree kept(0.1);
  for (unsigned i = 0; i < 8; i++)
    map_tests::putLeaf(kept,
                       {static_cast<int>(i & 1U) * 16, static_cast<int>(i >> 1 & 1U) * 16,
                        static_cast<int>(i >> 2) * 16},
                       12, 0.25F);
  EXPECT_EQ(finishLazyUpdates(kept, true, InnerNodes::Unknown), InnerNodes::Current);
}

}  // namespace
}  // namespace mrpt::fusion
