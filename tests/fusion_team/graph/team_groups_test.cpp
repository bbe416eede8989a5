// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of teams with maps of several places. */
#include "fusion_team/graph/team_groups.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fusion_team/graph/flat_team.h"
#include "fusion_team/graph/team_search.h"

namespace mrpt::fusion::test::team_groups_test {
namespace {

using Eigen::Isometry3d;

/** Maps 0 and 1 are of one place, maps 3 and 4 of another. Map 2 is a stranger: it confirms a part
 * of map 0 at a place where it contradicts map 1. */
class TwoPlaces : public TeamEvidence {
 public:
  static Isometry3d truth() { return at(10, 0); }

  size_t size() const override { return 5; }
  Matrix6d covariance(size_t, size_t, const Isometry3d&) const override {
    return 1e-4 * Matrix6d::Identity();
  }
  bool isSame(size_t, const Isometry3d& T, const Isometry3d& U) const override {
    return (T.translation() - U.translation()).norm() < 0.6;
  }
  bool isSure(size_t, size_t, const Isometry3d&) const override { return false; }
  std::optional<Isometry3d> sureMatch(size_t, size_t) const override { return {}; }
  Eigen::AlignedBox3d box(size_t) const override { return everywhere(); }
  double areaOfObstacle(size_t) const override { return 1; }
  double areaOf(size_t) const override { return 64; }
  ConflictTolerance tolerance(size_t) const override { return {0.5, 0.5}; }
  const PairEvidence& near(size_t a, size_t b, const Isometry3d& T) const override {
    const ObstacleSet low{0xffffffffU}, high{0xffffffff00000000U}, few{0xfffff00000000U}, no{0};
    static const PairEvidence none{}, right{{}, {low, no, no}, {low, no, no}},
        confirms{{}, {high, no, no}, {low, no, no}}, contradicts{{}, {no, no, few}, {no, no, no}};
    if (T.translation().norm() > 12) return none;
    if ((a == 0 && b == 1) || (a == 3 && b == 4)) return isSame(b, T, truth()) ? right : none;
    if (b == 2) return a == 0 ? confirms : contradicts;
    return none;
  }
};

const std::vector<std::string> kNames{"a", "b", "c", "d", "e"};

std::vector<JudgedWay> ways(double probability) {
  return {{{0, 1, TwoPlaces::truth()}, probability},
          {{0, 2, at(3, 0)}, 0},
          {{3, 4, TwoPlaces::truth()}, probability}};
}

TEST(TeamGroups, AStrangerDoesNotSpoilThePlacesOfOthers) {
  std::vector<Way> all;
  for (const JudgedWay& w : ways(0.99)) all.push_back(w.way);
  const auto together =
      judgeTeam(searchTeam(all, TwoPlaces(), 16), ways(0.99), TwoPlaces(), kNames, {});
  ASSERT_FALSE(together[1].placed) << "the stranger must matter, or this test shows nothing";

  const PlacedGroups groups = placeGroups(ways(0.99), TwoPlaces(), kNames, {});
  EXPECT_TRUE(groups.maps[1].placed);
  EXPECT_TRUE(groups.maps[1].pose->isApprox(TwoPlaces::truth(), 1e-6));
  for (const size_t k : {2, 3, 4}) EXPECT_FALSE(groups.maps[k].placed) << k;
  EXPECT_FALSE(groups.maps[2].reasons.empty());
}

TEST(TeamGroups, MapsOfAnotherPlaceAreAGroupOfTheirOwn) {
  const PlacedGroups groups = placeGroups(ways(0.99), TwoPlaces(), kNames, {});
  EXPECT_EQ(groups.others[3], std::vector<size_t>{4});
  EXPECT_EQ(groups.others[4], std::vector<size_t>{3});
  EXPECT_EQ(groups.maps[3].reasons.back(), "fits e, but not a: fuse them without it");
  for (const size_t k : {0, 1, 2}) EXPECT_TRUE(groups.others[k].empty()) << k;
}

TEST(TeamGroups, MapsThatNothingConnectsAreNoGroup) {
  const PlacedGroups groups = placeGroups(ways(0.5), TwoPlaces(), kNames, {});
  for (size_t k = 1; k < 5; k++) {
    EXPECT_FALSE(groups.maps[k].placed) << k;
    EXPECT_TRUE(groups.others[k].empty()) << k;
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::team_groups_test
