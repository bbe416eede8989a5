// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the search and the verdict of a team, on maps that are circles of obstacles. */
#include "fusion_team/graph/team_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fusion_team/graph/flat_team.h"
#include "fusion_team/graph/joint_verdict.h"
#include "fusion_team/graph/pose_graph.h"

namespace mrpt::fusion::test::team_search_test {
namespace {

using Eigen::Isometry3d;

/** Four maps on a square of 10 m. Neighbours confirm 32 of 64 obstacles of each other at the right
 * pose; at any other pose at which they meet, 16 obstacles lie in free space. Diagonal maps do not
 * meet at the right pose. */
class Square : public TeamEvidence {
 public:
  static Isometry3d truth(size_t k) {
    const double x[] = {0, 10, 10, 0}, y[] = {0, 0, 10, 10};
    return at(x[k], y[k], 0.3 * static_cast<double>(k));
  }
  static Isometry3d truth(size_t a, size_t b) { return truth(a).inverse() * truth(b); }
  static bool areNeighbours(size_t a, size_t b) { return (b - a) % 2 == 1; }

  size_t size() const override { return 4; }
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
  ConflictTolerance tolerance(size_t) const override { return {0.03, 0.01}; }
  const PairEvidence& near(size_t a, size_t b, const Isometry3d& T) const override {
    static const PairEvidence none{},
        right{{}, {{0xffffffffU << (a % 2 * 16)}, {0}, {0}}, {{0xffffffffU}, {0}, {0}}},
        wrong{{}, {{0xffffffffU}, {0}, {0xffff00000000U}}, {{0xffffffffU}, {0}, {0}}};
    if (T.translation().norm() > 12) return none;
    if (!areNeighbours(a, b)) return wrong;
    return isSame(b, T, truth(a, b)) ? right : wrong;
  }
};

std::vector<Way> waysAround(size_t links) {
  const std::pair<size_t, size_t> around[] = {{0, 1}, {1, 2}, {2, 3}, {0, 3}};
  std::vector<Way> ways;
  for (size_t i = 0; i < links; i++)
    ways.push_back(
        {around[i].first, around[i].second, Square::truth(around[i].first, around[i].second)});
  return ways;
}

std::vector<JudgedWay> judgedAs(double probability, const std::vector<Way>& ways) {
  std::vector<JudgedWay> judged;
  for (const Way& way : ways) judged.push_back({way, probability});
  return judged;
}

std::vector<PlacedMap> placed(const std::vector<Way>& ways, double probability,
                              double runner_up_of_2 = 0) {
  TeamSearchResult found = searchTeam(ways, Square(), 16);
  found.runner_up[2] = std::max(found.runner_up[2], runner_up_of_2);
  return judgeTeam(found, judgedAs(probability, ways), Square(), {"a", "b", "c", "d"}, {});
}

size_t numberOf(const std::vector<PlacedMap>& maps) {
  size_t n = 0;
  for (const PlacedMap& m : maps) n += m.placed ? 1 : 0;
  return n;
}

TEST(TeamSearch, FindsThePosesAtWhichAllPairsAgree) {
  std::vector<Way> ways = waysAround(4);
  ways.insert(ways.begin(), {0, 2, at(3, 1)});  // diagonal maps on each other
  ways.insert(ways.begin(), {0, 1, at(0, -5)});
  const TeamSearchResult found = searchTeam(ways, Square(), 16);
  for (size_t k = 1; k < 4; k++) {
    ASSERT_TRUE(found.best.pose[k]) << k;
    EXPECT_TRUE(
        (found.best.pose[0]->inverse() * *found.best.pose[k]).isApprox(Square::truth(0, k), 1e-6))
        << k;
    EXPECT_LT(found.runner_up[k], 0.75) << k;
  }
}

TEST(TeamSearch, WithoutWaysPlacesNothing) {
  const TeamSearchResult found = searchTeam({}, Square(), 16);
  for (const auto& pose : found.best.pose) EXPECT_FALSE(pose);
  EXPECT_EQ(reasonsAtMatch({}, "r1").size(), 0U) << "no place is preferred";
}

TEST(JointVerdict, ALoopOfUnsureMatchesPlacesAllMaps) {
  const auto maps = placed(waysAround(4), 0.3);
  EXPECT_EQ(numberOf(maps), 4U);
  EXPECT_EQ(maps[2].ways_in.size(), 2U);
  ASSERT_GE(maps[2].reasons.size(), 2U);
  EXPECT_EQ(maps[2].reasons[1],
            "0.0 % of the obstacles lie in free space of other maps, at most 10.0 % are allowed");
}

TEST(JointVerdict, AChainOfUnsureMatchesPlacesNoMapButTheFirst) {
  const auto maps = placed(waysAround(3), 0.9);
  EXPECT_EQ(numberOf(maps), 1U);
  EXPECT_TRUE(maps[0].placed);
  ASSERT_FALSE(maps[3].reasons.empty());
  EXPECT_NE(maps[3].reasons[0].find("no loop"), std::string::npos) << maps[3].reasons[0];
}

TEST(JointVerdict, AChainOfSureMatchesPlacesAllMaps) {
  EXPECT_EQ(numberOf(placed(waysAround(3), 0.96)), 4U) << "1 - 0.15 / 3 is 0.95";
}

TEST(JointVerdict, TwoHypothesesOfAPairAreOneWitness) {
  auto ways = waysAround(3);
  ways.push_back({2, 3, Square::truth(2, 3) * at(0.1, 0)});
  EXPECT_EQ(numberOf(placed(ways, 0.9)), 1U);
}

TEST(JointVerdict, AMapWithARivalIsNotPlacedButClosesTheLoopOfTheOthers) {
  const auto maps = placed(waysAround(4), 0.3, 0.95);
  EXPECT_EQ(numberOf(maps), 3U);
  EXPECT_FALSE(maps[2].placed);
  ASSERT_FALSE(maps[2].reasons.empty());
  EXPECT_NE(maps[2].reasons[0].find("another place reaches 95.0 % of the gain"), std::string::npos)
      << maps[2].reasons[0];
  const auto at_match = reasonsAtMatch(maps[2], "r1");
  ASSERT_EQ(at_match.size(), maps[2].reasons.size() + 1);
  EXPECT_EQ(at_match[0].find("the pose is that of the match with r1; all maps together prefer"),
            0U);
  EXPECT_EQ(at_match[1], maps[2].reasons[0]);
}

TEST(TeamScore, ContradictedObstaclesCountOverTheirTolerance) {
  const Square square;
  Configuration c;
  c.pose = {at(0, 0), std::nullopt, at(3, 1), std::nullopt};  // see wrong in Square::near()
  const TeamAreas areas = areasOf(0, ScoredTeam(c, square));
  EXPECT_EQ(areas.confirmed, 64) << "of map 0, and of map 2 by map 0";
  EXPECT_EQ(areas.displaced, 0);
  EXPECT_EQ(areas.contradicted, 16);
  EXPECT_NEAR(scoreOf(c, square), 64 - 16 / 0.01, 1e-9);
}

/** A square whose match of maps 0 and 2 is sure at a pose at which they contradict each other. */
class SquareWithASureMatch : public Square {
 public:
  static Isometry3d pose() { return at(3, 1); }
  bool isSure(size_t a, size_t b, const Isometry3d& T) const override {
    return a == 0 && b == 2 && isSame(b, T, pose());
  }
  std::optional<Isometry3d> sureMatch(size_t a, size_t b) const override {
    return a == 0 && b == 2 ? std::optional(pose()) : std::nullopt;
  }
};

TEST(TeamScore, ASureMatchExplainsItsConflicts) {
  const SquareWithASureMatch square;
  Configuration c;
  c.pose = {at(0, 0), std::nullopt, SquareWithASureMatch::pose(), std::nullopt};
  const TeamAreas areas = areasOf(0, ScoredTeam(c, square));
  EXPECT_EQ(areas.explained, 16);
  EXPECT_EQ(areas.contradicted, 0);
  EXPECT_EQ(areas.conflictRatio(), areasOf(0, ScoredTeam(c, Square())).conflictRatio());
  EXPECT_NEAR(scoreOf(c, square), 64 - 16 / square.tolerance(0).explained, 1e-9);
  c.pose[2] = at(6, 1);
  EXPECT_EQ(areasOf(0, ScoredTeam(c, square)).contradicted, 16) << "another place is not sure";
}

TEST(TeamScore, ASureMatchThatIsPartedIsLost) {
  const SquareWithASureMatch square;
  Configuration c;
  for (size_t k = 0; k < 4; k++) c.pose.emplace_back(Square::truth(k));
  const double confirmed = scoreOf(c, Square());
  EXPECT_EQ(scoreOf(c, square), confirmed - 64) << "the diagonal maps do not meet";
  const ScoredTeam team(c, square);
  EXPECT_EQ(team.known(0).denied, (ObstacleSet{0xffffffffU})) << "as the match confirms";
  EXPECT_EQ(team.known(1).denied, ObstacleSet());
  c.pose[2].reset();
  EXPECT_EQ(scoreOf(c, square), scoreOf(c, Square())) << "a map that is not placed parts nothing";
}

TEST(TeamScore, TheGainOfAMapIsTheIncreaseOfTheScore) {
  const SquareWithASureMatch square;
  for (const Isometry3d& T : {Square::truth(2), SquareWithASureMatch::pose(), at(6, 1)}) {
    ScoredTeam team({{at(0, 0), Square::truth(1), std::nullopt, std::nullopt}}, square);
    Addition early(2, T, team, -1e6);
    team.place(3, Square::truth(3));
    early.update(team, 3, std::vector<bool>(4, true));
    const double before = team.score();
    const double gain = Addition(2, T, team, -1e6).gain(team);
    EXPECT_NEAR(early.gain(team), gain, 1e-9) << "also of a map that was placed later";
    team.place(2, T);
    EXPECT_NEAR(team.score(), before + gain, 1e-9);
    team.remove(2);
    EXPECT_NEAR(team.score(), before, 1e-9);
    EXPECT_EQ(team.known(0).denied, ObstacleSet());
  }
}

/** Maps that confirm each other at some places only. They do not meet anywhere else. */
class Places : public TeamEvidence {
 public:
  struct Place {
    Way way;
    size_t confirmed;  // obstacles of each of both maps
  };
  Places(size_t maps, const std::vector<Place>& places) : maps_(maps) {
    for (const auto& [way, confirmed] : places) {
      PairEvidence e{way.T_a_b, emptySets(), emptySets()};
      e.of_a.confirmed[way.b] = e.of_b.confirmed[way.a] = (uint64_t{1} << confirmed) - 1;
      known_.push_back({way, e});
    }
  }
  size_t size() const override { return maps_; }
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
  double areaOf(size_t) const override { return 64 * double(maps_); }
  ConflictTolerance tolerance(size_t) const override { return {0.03, 0.01}; }
  const PairEvidence& near(size_t a, size_t b, const Isometry3d& T) const override {
    static const PairEvidence none{};
    for (const auto& [way, evidence] : known_)
      if (way.a == a && way.b == b && isSame(b, way.T_a_b, T)) return evidence;
    return none;
  }
  std::vector<Way> ways() const {
    std::vector<Way> ways;
    for (const auto& [way, evidence] : known_) ways.push_back(way);
    return ways;
  }

 private:
  ComparedObstacles emptySets() const {
    return {ObstacleSet(maps_), ObstacleSet(maps_), ObstacleSet(maps_)};  // a word for each map
  }
  size_t maps_;
  std::vector<std::pair<Way, PairEvidence>> known_;
};

TEST(TeamSearch, ARivalCountsByWhatConnectsItsGroups) {
  // Two pairs of maps hold together. Between the pairs one place confirms 20 obstacles, another 12.
  const Places places(4, {{{0, 1, at(10, 0)}, 60},
                          {{2, 3, at(10, 0)}, 60},
                          {{1, 2, at(10, 0)}, 20},
                          {{1, 2, at(10, 5)}, 12}});
  const TeamSearchResult found = searchTeam(places.ways(), places, 16);
  ASSERT_TRUE(found.best.pose[0] && found.best.pose[3]);
  EXPECT_TRUE((found.best.pose[0]->inverse() * *found.best.pose[3]).isApprox(at(30, 0), 1e-6));
  EXPECT_EQ(found.runner_up[0], 0) << "the frame is that of the first map";
  EXPECT_NEAR(found.runner_up[1], 12.0 / (60 + 20), 1e-9) << "map 1 alone at the other place";
  EXPECT_NEAR(found.runner_up[2], 12.0 / 20, 1e-9);
  EXPECT_NEAR(found.runner_up[3], 12.0 / 20, 1e-9);
}

/** Four maps of one place where things move. Maps 0 and 1 confirm each other, and so do 2 and 3. At
 * the right pose of maps 1 and 2 each confirms what the other maps confirm already, and 8 more
 * obstacles; 4 obstacles of each have moved. At another pose they confirm 10 new obstacles and have
 * no conflicts. */
class PlaceWhereThingsMove : public Places {
 public:
  static Isometry3d next() { return at(1, 0); }
  /** \param[in] sure_matches Number of sure matches between the maps 0 and 1 and the maps 2 and 3.
   */
  explicit PlaceWhereThingsMove(size_t sure_matches)
      : Places(4, {{{0, 1, next()}, 40}, {{2, 3, next()}, 40}, {{1, 2, at(40, 0)}, 10}}),
        sure_matches_(sure_matches) {}
  bool isSure(size_t a, size_t b, const Isometry3d& T) const override {
    return a == 1 && b == 2 && isSame(b, T, next());
  }
  std::optional<Isometry3d> sureMatch(size_t a, size_t b) const override {
    if (a == 1 && b == 2 && sure_matches_ > 0) return next();
    if (a == 0 && b == 3 && sure_matches_ > 1) return at(3, 0);
    return std::nullopt;
  }
  const PairEvidence& near(size_t a, size_t b, const Isometry3d& T) const override {
    static const ObstacleSet no(4);
    static const PairEvidence right{next(), {sees(0), no, moved()}, {sees(3), no, moved()}};
    return isSure(a, b, T) ? right : Places::near(a, b, T);
  }
  TeamSearchResult found() const {
    std::vector<Way> all = ways();
    all.push_back({1, 2, next()});
    return searchTeam(all, *this, 16);
  }

 private:
  /** The 40 obstacles that the partner of a map confirms, and 8 others. */
  static ObstacleSet sees(size_t partner) {
    ObstacleSet set(4);
    set[partner] = (uint64_t{1} << 48) - 1;
    return set;
  }
  static ObstacleSet moved() {
    ObstacleSet set(4);
    set[1] = 0xfU << 8;
    return set;
  }
  size_t sure_matches_;
};

TEST(TeamSearch, MapsThatOtherMapsConfirmAreNotLaidApartAgainstSureMatches) {
  const auto is_right = [](const PlaceWhereThingsMove& place, const TeamSearchResult& found) {
    return place.isSure(1, 2, found.best.pose[1]->inverse() * *found.best.pose[2]);
  };
  const PlaceWhereThingsMove unsure(0), sure(1), very_sure(2);
  EXPECT_FALSE(is_right(unsure, unsure.found())) << "16 obstacles less 8, not 20";
  EXPECT_TRUE(is_right(sure, sure.found()));
  EXPECT_TRUE(is_right(very_sure, very_sure.found()));
  EXPECT_GT(sure.found().runner_up[3], 1) << "one sure match may be wrong";
  EXPECT_EQ(very_sure.found().runner_up[3], 0) << "two sure matches refute the other pose";
}

/** Places of which one is that of a sure match. */
class PlacesWithASureMatch : public Places {
 public:
  PlacesWithASureMatch(size_t maps, const std::vector<Place>& places, const Way& sure)
      : Places(maps, places), sure_(sure) {}
  std::optional<Isometry3d> sureMatch(size_t a, size_t b) const override {
    return a == sure_.a && b == sure_.b ? std::optional(sure_.T_a_b) : std::nullopt;
  }

 private:
  Way sure_;
};

TEST(TeamSearch, OneSureMatchAloneDoesNotRefuteARival) {
  // Maps 1 and 3 say that map 2 is at 20 m. The match of maps 0 and 2 is sure of another place.
  const Way sure{0, 2, at(0, 10)};
  const PlacesWithASureMatch places(4,
                                    {{{0, 1, at(10, 0)}, 40},
                                     {{1, 2, at(10, 0)}, 30},
                                     {{0, 3, at(15, 0)}, 40},
                                     {{2, 3, at(-5, 0)}, 30},
                                     {sure, 35}},
                                    sure);
  const TeamSearchResult found = searchTeam(places.ways(), places, 16);
  ASSERT_TRUE(found.best.pose[0] && found.best.pose[2]);
  EXPECT_GT(found.runner_up[2], 0.8) << "map 2 must not be placed";
}

TEST(JointVerdict, AChainOverlapsAsItsWeakestPair) {
  const Places places(4,
                      {{{0, 1, at(10, 0)}, 40}, {{1, 2, at(10, 0)}, 10}, {{0, 2, at(20, 0)}, 16}});
  Configuration c;
  c.pose = {at(0, 0), at(10, 0), at(20, 0), std::nullopt};
  const std::vector<double> overlap = overlapsWith(0, c, places);
  const double area = places.areaOf(0);
  EXPECT_EQ(overlap, (std::vector<double>{1, 40 / area, 16 / area, 0})) << "map 2 meets map 0 best";
  EXPECT_EQ(overlapsWith(2, c, places)[1], 16 / area) << "over map 0";
}

TEST(JointVerdict, StrangersThatOverlapEachOtherAreNotPlacedByAMatchThatClaimsToBeSure) {
  const Places places(4,
                      {{{0, 1, at(10, 0)}, 40}, {{1, 2, at(10, 0)}, 1}, {{2, 3, at(10, 0)}, 40}});
  const auto maps = judgeTeam(searchTeam(places.ways(), places, 16), judgedAs(0.99, places.ways()),
                              places, {"a", "b", "c", "d"}, {});
  EXPECT_TRUE(maps[1].placed);
  for (const size_t k : {2U, 3U}) {
    EXPECT_FALSE(maps[k].placed) << k;
    EXPECT_LT(maps[k].probability, 0.85) << k;
    ASSERT_FALSE(maps[k].reasons.empty());
    EXPECT_NE(maps[k].reasons[0].find("the place is right with a probability of"),
              std::string::npos)
        << maps[k].reasons[0];
  }
}

TEST(PoseGraph, SpreadsTheErrorOfALoop) {
  // Each of four sides is measured 0.1 m too long. A square of four equal sides closes.
  std::vector<std::optional<Isometry3d>> pose{at(0, 0), at(10.1, 0), at(10.1, 10.1), at(0.3, 10.1)};
  optimizePoses(
      {{0, 1, at(10.1, 0)}, {1, 2, at(0, 10.1)}, {2, 3, at(-10.1, 0)}, {0, 3, at(0, 10.1)}}, pose);
  EXPECT_TRUE(pose[0]->isApprox(at(0, 0), 1e-9)) << "the first pose keeps its value";
  EXPECT_NEAR(pose[3]->translation().x(), 0, 1e-3);
  EXPECT_NEAR(pose[3]->translation().y(), 10.1, 1e-3);
}

TEST(PoseGraph, AWrongConstraintLosesItsWeight) {
  std::vector<std::optional<Isometry3d>> pose{at(0, 0), at(1, 0), at(2, 0)};
  optimizePoses({{0, 1, at(1, 0)}, {1, 2, at(1, 0)}, {0, 2, at(2, 0)}, {0, 2, at(9, 4)}}, pose);
  EXPECT_NEAR(pose[2]->translation().x(), 2, 0.05);
  EXPECT_NEAR(pose[2]->translation().y(), 0, 0.05);
}

}  // namespace
}  // namespace mrpt::fusion::test::team_search_test
