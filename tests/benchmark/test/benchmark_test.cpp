// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <tuple>

#include "../map_pair.h"
#include "../truth.h"
#include "support/test_maps.h"

namespace mrpt::fusion::benchmark {
namespace {

using test::kDegree;
using test::MapWriter;
using test::poseOf;

MapPair pairOf(const Eigen::Isometry3d& T_a_b, const Eigen::Vector3d& centre_of_b) {
  MapPair pair;
  pair.T_a_b = T_a_b;
  pair.centre_of_b = centre_of_b;
  return pair;
}

TEST(BenchmarkStarts, AreThePapersGrid) {
  const auto starts = paperStarts();
  ASSERT_EQ(starts.size(), 125U);
  std::set<std::tuple<double, double, long>> places;
  for (const Start& s : starts) {
    places.emplace(s.dx, s.dy, std::lround(s.dyaw / (7.5 * kDegree)));
    EXPECT_LE(std::abs(s.dx), 2);
    EXPECT_LE(std::abs(s.dy), 2);
    EXPECT_LE(std::abs(s.dyaw), 15 * kDegree + 1e-9);
  }
  EXPECT_EQ(places.size(), 125U);
}

TEST(BenchmarkStarts, TurnAboutTheMiddleOfMapB) {
  const MapPair pair = pairOf(poseOf(20, 3, 0, 40), {5, -2, 1});
  const Eigen::Isometry3d start = poseOf(Start{0, 1.5, -2, 0.2}, pair);
  const Eigen::Vector3d moved = start * pair.centre_of_b - pair.T_a_b * pair.centre_of_b;
  EXPECT_TRUE(moved.isApprox(Eigen::Vector3d(1.5, -2, 0), 1e-9)) << moved.transpose();
  const PoseError error = errorOf(start, pair);
  EXPECT_NEAR(error.angle, 0.2, 1e-9);
  EXPECT_NEAR(error.centre, 2.5, 1e-9);
}

TEST(BenchmarkErrors, ByHand) {
  // Turned by 10 deg about B's middle, which is 10 m from A's origin: no displacement there, but a
  // lever of 10 m in the paper's measure.
  const MapPair pair = pairOf(poseOf(10, 0, 0, 0), {0, 0, 0});
  const PoseError error = errorOf(pair.T_a_b * poseOf(0, 0, 0, 10), pair);
  EXPECT_NEAR(error.centre, 0, 1e-9);
  EXPECT_NEAR(error.angle, 10 * kDegree, 1e-9);
  EXPECT_NEAR(error.paper, 2 * 10 * std::sin(5 * kDegree), 1e-9);
}

TEST(BenchmarkCrop, KeepsWhatLiesBeyondThePlaneAndNothingElse) {
  // A pruned block of free space with walls, cut off the axes of the grid.
  const auto map = MapWriter(0.1)
                       .box({0, 0, 0}, {31, 31, 31}, test::kFree)
                       .box({0, 0, 0}, {31, 31, 0}, test::kOccupied)
                       .pruned();
  const Eigen::Vector3d direction = Eigen::Vector3d(1, 0.5, -0.2).normalized();
  const double offset = 1.3;
  const auto part = cropMap(*map, direction, offset);
  for (int x = 0; x < 32; x++)
    for (int y = 0; y < 32; y++)
      for (int z = 0; z < 32; z++) {
        const Eigen::Vector3d centre = test::centreOf({x, y, z}, 0.1);
        const auto* node = part->search(test::keyOf({x, y, z}));
        ASSERT_EQ(node != nullptr, direction.dot(centre) > offset) << centre.transpose();
        if (node) {
          ASSERT_EQ(node->getLogOdds(), map->search(test::keyOf({x, y, z}))->getLogOdds());
        }
      }
}

TEST(BenchmarkPairs, TheMirrorImageHasEachVoxelOnTheOtherSide) {
  const auto map = test::MapWriter()
                       .box({0, 0, 0}, {15, 15, 15}, test::kFree)
                       .box({5, 2, 0}, {5, 9, 15}, test::kOccupied)
                       .pruned();
  const auto image = mirrored(*map);
  EXPECT_EQ(image->getNumLeafNodes(), map->getNumLeafNodes());
  for (int x = 0; x < 16; x++)
    for (int y = 0; y < 16; y++) {
      const auto* node = image->search(test::keyOf({-1 - x, y, 3}));
      ASSERT_TRUE(node) << x << " " << y;
      ASSERT_EQ(node->getLogOdds(), map->search(test::keyOf({x, y, 3}))->getLogOdds());
    }
}

TEST(BenchmarkTruth, OfAMapAgainstItselfIsAsSureAsTheMap) {
  const auto map = test::apartment();
  const TruthComparison same = compareWithTruth(*map, *map);
  EXPECT_DOUBLE_EQ(same.f1, 1);
  EXPECT_LT(same.log_loss, 0.13);  // its voxels are 0.12 or 0.97
  EXPECT_GT(same.log_loss, 0.02);
}

TEST(BenchmarkTruth, ByHandWithPrunedLeavesAndUnknownSpace) {
  // Truth: eight voxels free (one leaf), two occupied. Map: two of the free known as occupied, six
  // as free, one of the occupied as occupied and one unknown; one voxel that the truth does not
  // know.
  const auto truth = MapWriter(0.1)
                         .box({0, 0, 0}, {1, 1, 1}, test::kFree)
                         .box({4, 0, 0}, {5, 0, 0}, test::kOccupied)
                         .pruned();
  const auto map = MapWriter(0.1)
                       .box({0, 0, 0}, {1, 1, 1}, test::kFree)
                       .box({0, 0, 0}, {0, 0, 1}, test::kOccupied)
                       .voxel({4, 0, 0}, test::kOccupied)
                       .voxel({9, 9, 9}, test::kOccupied)
                       .pruned();
  const double high = 1 / (1 + std::exp(-3.5)), low = 1 / (1 + std::exp(2.0));
  const TruthComparison c = compareWithTruth(*truth, *map);
  EXPECT_NEAR(
      c.log_loss,
      -(2 * std::log(1 - high) + 6 * std::log(1 - low) + std::log(high) + std::log(0.5)) / 10,
      1e-6);
  EXPECT_NEAR(c.brier, (2 * high * high + 6 * low * low + (1 - high) * (1 - high) + 0.25) / 10,
              1e-6);
  EXPECT_NEAR(c.f1, 2.0 * 1 / (2 + 3), 1e-12);
}

TEST(BenchmarkTruth, LabelsWhatIsKnownByTheWorld) {
  const auto known = MapWriter(0.1)
                         .box({0, 0, 0}, {3, 3, 3}, test::kFree)
                         .voxel({6, 0, 0}, test::kOccupied)
                         .pruned();
  const auto world =
      MapWriter(0.1).voxel({1, 2, 3}, test::kOccupied).voxel({20, 0, 0}, test::kOccupied).pruned();
  const auto labels = labelled(*known, *world);
  const auto at = [&](const test::Cell& c) { return labels->search(test::keyOf(c)); };
  EXPECT_TRUE(labels->isNodeOccupied(at({1, 2, 3})));
  EXPECT_FALSE(labels->isNodeOccupied(at({0, 0, 0})));
  EXPECT_FALSE(labels->isNodeOccupied(at({6, 0, 0})));  // a person, say
  EXPECT_EQ(at({20, 0, 0}), nullptr);                   // nobody looked there
}

}  // namespace
}  // namespace mrpt::fusion::benchmark
