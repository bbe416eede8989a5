// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the moves of blocks of maps, on maps in a row. */
#include "fusion_team/graph/other_places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "fusion_team/graph/flat_team.h"
#include "fusion_team/graph/team_search.h"

namespace mrpt::fusion::test::other_places_test {
namespace {

using Eigen::Isometry3d;

/** Six maps in a row, 10 m apart. Neighbours confirm each other. Up to 0.6 m beside the right pose
 * some of their obstacles are displaced. Map 3 also fits beside map 2, but less well. */
class Row : public TeamEvidence {
 public:
  static Isometry3d next() { return at(10, 0); }
  static Isometry3d beside() { return at(0, -10); }

  size_t size() const override { return 6; }
  Matrix6d covariance(size_t, size_t, const Isometry3d&) const override {
    return 1e-4 * Matrix6d::Identity();
  }
  bool isSame(size_t, const Isometry3d& T, const Isometry3d& U) const override {
    return isNear(T, U, 0.6);
  }
  bool isSure(size_t, size_t, const Isometry3d&) const override { return false; }
  std::optional<Isometry3d> sureMatch(size_t, size_t) const override { return {}; }
  Eigen::AlignedBox3d box(size_t) const override {
    return {Eigen::Vector3d::Constant(-6), Eigen::Vector3d::Constant(6)};
  }
  double areaOfObstacle(size_t) const override { return 1; }
  double areaOf(size_t) const override { return 256; }
  ConflictTolerance tolerance(size_t) const override { return {0.03, 0.01}; }
  const PairEvidence& near(size_t a, size_t b, const Isometry3d& T) const override {
    static const ObstacleSet no(4), low{~0ULL, 0, 0, 0}, high{0, 0, 0, ~0ULL};
    static const ObstacleSet few{0, 0xffffULL, 0, 0}, others{0, 0, 0xffffULL, 0};
    static const PairEvidence apart{}, right{next(), {high, no, no}, {low, no, no}, next()},
        displaced{next(), {high, others, no}, {low, others, no}, next()},
        alias{beside(), {few, no, no}, {few, no, no}},
        wrong{next(), {low, no, others}, {low, no, others}};
    if (T.translation().norm() > 12) return apart;
    if (b == a + 1 && isNear(T, next(), 0.1)) return right;
    if (b == a + 1 && isNear(T, next(), 0.6)) return displaced;
    return a == 2 && b == 3 && isNear(T, beside(), 0.6) ? alias : wrong;
  }

 private:
  static bool isNear(const Isometry3d& T, const Isometry3d& U, double distance) {
    return (T.translation() - U.translation()).norm() < distance;
  }
};

/** The maps 3, 4 and 5 are beside map 2. */
Configuration misplaced() {
  Configuration c;
  for (int k = 0; k < 6; k++) c.pose.emplace_back(k < 3 ? at(10 * k, 0) : at(10 * k - 10, -10));
  c.score = scoreOf(c, Row());
  return c;
}

/** Ways from map to map. The way between the maps 2 and 3 is 0.3 m off. */
TeamWays waysAlong() {
  std::vector<Way> ways{{2, 3, Row::beside()}, {2, 3, at(10, 0.3)}};
  for (const size_t a : {0, 1, 3, 4}) ways.push_back({a, a + 1, Row::next()});
  return {ways, 6};
}

TEST(BlocksOf, AreTheMapsAndThePiecesBetweenLinks) {
  const auto blocks = blocksOf(misplaced(), Row());
  const auto has = [&](const std::vector<size_t>& block) {
    return std::find(blocks.begin(), blocks.end(), block) != blocks.end();
  };
  for (size_t k = 0; k < 6; k++) EXPECT_TRUE(has({k})) << k;
  EXPECT_TRUE(has({3, 4, 5}));
  EXPECT_TRUE(has({2, 3})) << "between two links";
  EXPECT_FALSE(has({2, 3, 4, 5})) << "more than half of the maps";
  EXPECT_FALSE(has({3, 5})) << "not in one piece";
}

TEST(OtherPlaces, HaveBlocksWhereTheyFitAfterSettling) {
  const Configuration c = misplaced();
  const auto rivals = otherPlaces(c, waysAlong(), Row());
  ASSERT_FALSE(rivals.empty());
  const Configuration& best = *std::max_element(
      rivals.begin(), rivals.end(), [](const auto& g, const auto& h) { return g.score < h.score; });
  EXPECT_GT(best.score, c.score);
  EXPECT_LT((best.pose[2]->inverse() * *best.pose[3]).translation().y(), 0.1);
  EXPECT_NEAR((best.pose[2]->inverse() * *best.pose[5]).translation().x(), 30, 0.1);
}

TEST(OtherPlaces, ASearchMovesMoreThanTwoMapsTogether) {
  Configuration alone = misplaced();
  improve(alone, waysAlong(), Row(), Moves::OfOneOrTwo);
  EXPECT_EQ(alone.score, misplaced().score) << "moves of two maps are not enough";
  const TeamSearchResult found = searchTeam(waysAlong().all, Row(), 24);
  for (size_t k = 1; k < 6; k++) {
    ASSERT_TRUE(found.best.pose[k]) << k;
    EXPECT_TRUE(Row().isSame(k, found.best.pose[0]->inverse() * *found.best.pose[k],
                             at(10 * static_cast<double>(k), 0)))
        << k;
  }
}

TEST(Crossed, GroupsLieToEachOtherAsInTheOtherConfiguration) {
  Configuration right;
  for (int k = 0; k < 6; k++) right.pose.emplace_back(at(10 * k, 0));
  right.score = scoreOf(right, Row());
  const auto moved = crossed(misplaced(), right, Row());
  ASSERT_FALSE(moved.empty());
  for (const Configuration& c : moved) {
    for (size_t k = 0; k < 5; k++)
      EXPECT_TRUE((c.pose[k]->inverse() * *c.pose[k + 1]).isApprox(Row::next(), 1e-6)) << k;
    EXPECT_NEAR(c.score, right.score, 1e-6);
  }
  EXPECT_TRUE(crossed(right, right, Row()).empty()) << "one group";
}

}  // namespace
}  // namespace mrpt::fusion::test::other_places_test
