// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/fusion/map_fusion.h>
#include <mrpt/fusion/poses.h>
#include <mrpt/fusion/voxels.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include "fusion_octree/resampling.h"
#include "support/apartment_pair.h"

namespace mrpt::fusion::test::map_fusion_test {
namespace {

using mrpt::fusion::FusionResult;
using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationLocalMap;
using mrpt::slam::CProbabilisticMapMatching;

constexpr double kVoxel = 0.2;

CObservationLocalMap::Ptr sent(const std::string& robot, const octomap::OcTree& map) {
  auto o = CObservationLocalMap::Create();
  o->sensorLabel = robot;
  o->map = std::make_shared<CProbOctoMap>(std::make_unique<octomap::OcTree>(map));
  return o;
}

/** Three robots in one apartment: `a` and `c` share nothing, `b` shares a part with each. */
struct Mission {
  const ApartmentPair pair{kVoxel};
  const Eigen::Isometry3d T_c_w = poseOf(-7, -3, -1, 140, 0.5, 0.4);
  const CObservationLocalMap::Ptr a = sent("a", *pair.map_a), b = sent("b", *pair.map_b);

  /** The part of the world from so many cells of 0.1 m in x on, to 99, in a frame of its own. */
  CObservationLocalMap::Ptr c(int from_x) const {
    return sent("c", *mrpt::fusion::transformOcTree(*apartment({from_x, 0, 0}, {99, 69, 25}), T_c_w,
                                                    kVoxel));
  }
};

const Mission& mission() {
  static const Mission m;
  return m;
}

double distance(const mrpt::fusion::FusionMember& member, const Eigen::Isometry3d& truth) {
  return (toEigen(member.pose.mean).translation() - truth.translation()).norm();
}

size_t occupiedIn(const CProbOctoMap& map) { return statisticsOf(map.octree()).occupied; }

TEST(FusingMany, JoinsAllThatMeet) {
  CProbabilisticMapMatching matching;
  std::vector<std::string> matched;
  const FusionResult r = fuseMaps(matching, {mission().a, mission().b}, false,
                                  [&](const std::string& robot, size_t joined) {
                                    matched.push_back(robot + std::to_string(joined));
                                  });
  ASSERT_EQ(r.members.size(), 2U);
  EXPECT_TRUE(r.isComplete());
  EXPECT_FALSE(r.members[0].hasMatch());
  EXPECT_TRUE(r.members[1].alignment.evaluation.accepted);
  EXPECT_LT(distance(r.members[1], mission().pair.truth), kVoxel);
  EXPECT_EQ(matched, std::vector<std::string>{"b1"});
  EXPECT_GT(occupiedIn(r.map), occupiedIn(dynamic_cast<const CProbOctoMap&>(*mission().a->map)));
}

TEST(FusingMany, MeetsThroughAThird) {
  // Of x, a knows 0 to 65, b 30 to 99 and c 66 to 99: c has nothing in common with a.
  CProbabilisticMapMatching matching;
  const FusionResult r = fuseMaps(matching, {mission().a, mission().c(66), mission().b});
  EXPECT_TRUE(r.members[2].joined);
  ASSERT_TRUE(r.members[1].joined) << "through b";
  EXPECT_LT(distance(r.members[1], mission().pair.T_a_w * mission().T_c_w.inverse()), 2 * kVoxel)
      << "two matches, a voxel each";
}

TEST(FusingMany, LeavesOutWhatIsFromElsewhere) {
  const auto elsewhere = [] {
    MapWriter hall(kVoxel);
    hall.box({0, 0, 0}, {60, 40, 0}, kOccupied).box({0, 0, 1}, {60, 40, 10}, kFree);
    return sent("x", *hall.pruned());
  }();
  CProbabilisticMapMatching matching;
  const std::vector<CObservationLocalMap::Ptr> maps = {mission().a, elsewhere, mission().b};
  const FusionResult r = fuseMaps(matching, maps);
  EXPECT_FALSE(r.members[1].joined);
  EXPECT_FALSE(r.members[1].alignment.evaluation.accepted);
  EXPECT_TRUE(r.members[2].joined);
  EXPECT_FALSE(r.isComplete());
  EXPECT_TRUE(fuseMaps(matching, maps, true).members[1].joined) << "forced";
}

TEST(FusingMany, UsesThePosesThatTheMapsBring) {
  // The common frame is somewhere. A wrong pose with a small covariance is believed: the other map
  // is only looked for there. A wrong pose without a covariance is a hint.
  const Eigen::Isometry3d T_common_a = poseOf(100, 50, 3, 77, 0, 0);
  auto a = CObservationLocalMap::Create(*mission().a),
       b = CObservationLocalMap::Create(*mission().b);
  a->pose = mrpt::poses::CPose3DPDFGaussian(toPose(T_common_a));
  const auto fused = [&](const Eigen::Isometry3d& T_a_b, double variance = 0) {
    b->pose = mrpt::poses::CPose3DPDFGaussian(toPose(T_common_a * T_a_b));
    b->pose.cov.setDiagonal(6, variance);
    CProbabilisticMapMatching matching;
    return fuseMaps(matching, {a, b}).members[1];
  };
  const auto right = fused(poseOf(0.5, -0.3, 0, 5, 0, 0) * mission().pair.truth);
  EXPECT_TRUE(right.joined);
  EXPECT_LT(distance(right, mission().pair.truth), kVoxel);
  const Eigen::Isometry3d elsewhere = poseOf(40, 0, 0, 0, 0, 0) * mission().pair.truth;
  const auto hinted = fused(elsewhere);
  EXPECT_TRUE(hinted.joined);
  EXPECT_LT(distance(hinted, mission().pair.truth), kVoxel);
  const auto wrong = fused(elsewhere, 0.01);
  EXPECT_FALSE(wrong.joined);
  EXPECT_GT(distance(wrong, mission().pair.truth), 20);
}

TEST(FusingMany, FindsOutWhereEdgesAre) {
  auto edges = CObservationLocalMap::Create();
  edges->sensorLabel = "e";
  edges->map =
      std::make_shared<CEdgeVoxelMap>(dynamic_cast<const CProbOctoMap&>(*mission().b->map));
  CProbabilisticMapMatching matching;
  const FusionResult r = fuseMaps(matching, {edges, mission().a, mission().b});
  EXPECT_TRUE(r.members[1].joined) << "the first map that is one";
  EXPECT_FALSE(r.members[0].joined);
  EXPECT_TRUE(r.members[0].alignment.by_edges);
  EXPECT_LT(distance(r.members[0], mission().pair.truth), 2 * kVoxel);
  EXPECT_TRUE(r.isComplete()) << "nothing more can be expected of edges";
}

TEST(FusingMany, SaysWhoseMapIsNone) {
  CProbabilisticMapMatching matching;
  auto points = CObservationLocalMap::Create();
  points->sensorLabel = "p";
  points->map = std::make_shared<mrpt::maps::CSimplePointsMap>();
  auto empty = sent("e", octomap::OcTree(kVoxel));
  const auto errorOf = [&](const std::vector<CObservationLocalMap::Ptr>& maps) {
    try {
      fuseMaps(matching, maps);
    } catch (const std::exception& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(errorOf({mission().a, points}).find("p: "), 0U);
  EXPECT_EQ(errorOf({points, mission().a}).find("p: "), 0U);
  EXPECT_EQ(errorOf({mission().a, empty}).find("e: "), 0U);
  EXPECT_NE(errorOf({}), "");
  EXPECT_NE(errorOf({mission().a, CObservationLocalMap::Create()}), "");
}

}  // namespace
}  // namespace mrpt::fusion::test::map_fusion_test
