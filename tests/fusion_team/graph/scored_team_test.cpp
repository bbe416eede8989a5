// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the score of a configuration and of what a placed map changes. */
#include "fusion_team/graph/scored_team.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "fusion_team/graph/flat_team.h"

namespace mrpt::fusion::test::scored_team_test {
namespace {

using Eigen::Isometry3d;

constexpr size_t kObstacles = 128;

ObstacleSet drawSet(std::mt19937& random, unsigned one_of) {
  ObstacleSet set(kObstacles / 64);
  for (size_t i = 0; i < kObstacles; i++)
    if (random() % one_of == 0) set[i / 64] |= uint64_t{1} << (i % 64);
  return set;
}

/** Maps that all meet, with evidence that does not depend on the poses. */
class Evidence : public TeamEvidence {
 public:
  explicit Evidence(std::vector<std::vector<PairEvidence>> pairs) : pairs_(std::move(pairs)) {}
  size_t size() const override { return pairs_.size(); }
  const PairEvidence& near(size_t a, size_t b, const Isometry3d&) const override {
    return pairs_[a][b];
  }
  Matrix6d covariance(size_t, size_t, const Isometry3d&) const override {
    return 1e-4 * Matrix6d::Identity();
  }
  bool isSame(size_t, const Isometry3d&, const Isometry3d&) const override { return true; }
  bool isSure(size_t a, size_t b, const Isometry3d&) const override { return a == 0 && b == 3; }
  std::optional<Isometry3d> sureMatch(size_t, size_t) const override { return {}; }
  Eigen::AlignedBox3d box(size_t) const override { return everywhere(); }
  double areaOfObstacle(size_t) const override { return 0.5; }
  double areaOf(size_t) const override { return 0.5 * kObstacles; }
  ConflictTolerance tolerance(size_t) const override { return {0.25, 0.125}; }

 private:
  std::vector<std::vector<PairEvidence>> pairs_;  // by a and b
};

/** \a n maps. Each obstacle of a pair is in at most one of its sets. */
Evidence drawEvidence(size_t n, unsigned seed) {
  std::mt19937 random(seed);
  const auto draw = [&] {
    ComparedObstacles o{drawSet(random, 2), drawSet(random, 5), drawSet(random, 9)};
    for (size_t w = 0; w < o.confirmed.size(); w++) {
      o.displaced[w] &= ~o.confirmed[w];
      o.contradicted[w] &= ~(o.confirmed[w] | o.displaced[w]);
    }
    return o;
  };
  std::vector<std::vector<PairEvidence>> pairs(n, std::vector<PairEvidence>(n));
  for (size_t b = 1; b < n; b++)
    for (size_t a = 0; a < b; a++) pairs[a][b] = {at(0, 0), draw(), draw()};
  return Evidence(pairs);
}

TEST(ObstacleCounts, CountEachObstacleUpToTheirLimit) {
  std::mt19937 random(1);
  ObstacleCounts counts;
  EXPECT_EQ(counts[5], 0U);
  std::vector<unsigned> expected(kObstacles);
  for (int round = 0; round < 40; round++) {
    const ObstacleSet set = drawSet(random, 2);
    counts.add(set);
    for (size_t i = 0; i < kObstacles; i++)
      if (set[i / 64] >> (i % 64) & 1U)
        expected[i] = std::min(expected[i] + 1, ObstacleCounts::kMost);
    for (size_t i = 0; i < kObstacles; i++) ASSERT_EQ(counts[i], expected[i]) << round << " " << i;
  }
}

TEST(ConflictShares, AnObstacleCountsByTheShareOfTheMapsThatSeeAConflict) {
  const ObstacleSet no{0}, all{0b1111};
  KnownObstacles known;
  unite(known, {all, no, no}, Standing::Unsure);
  unite(known, {{0b1110}, {0b0001}, no}, Standing::Unsure);
  unite(known, {{0b1100}, {0b0001}, {0b0010}}, Standing::Unsure);
  const ConflictShares shares = conflictShares(known);
  EXPECT_DOUBLE_EQ(shares.displaced, 2.0 / 3);
  EXPECT_DOUBLE_EQ(shares.contradicted, 1.0 / 3);
}

TEST(ScoredTeam, MoreMapsWithTheSameShareOfConflictsDoNotLoseScore) {
  // Of each two maps, 1 of 64 obstacles is displaced, another one for each pair.
  const auto scoreOfMap0 = [](size_t n) {
    std::vector<std::vector<PairEvidence>> pairs(n, std::vector<PairEvidence>(n));
    for (size_t b = 1; b < n; b++)
      for (size_t a = 0; a < b; a++) {
        const uint64_t displaced = uint64_t{1} << b;
        const ComparedObstacles o{{~displaced, 0}, {displaced, 0}, {0, 0}};
        pairs[a][b] = {at(0, 0), o, o};
      }
    const Evidence evidence(pairs);
    const ScoredTeam team({std::vector<std::optional<Isometry3d>>(n, at(0, 0)), 0}, evidence);
    return team.scoreOf(team.known(0), 0);
  };
  EXPECT_DOUBLE_EQ(scoreOfMap0(2), 0.5 * (63 - 1 / 0.25));
  for (size_t n = 3; n < 12; n++) EXPECT_GE(scoreOfMap0(n), scoreOfMap0(2)) << n;
}

TEST(ScoredTeam, TheGainOfAMapIsTheDifferenceOfTheScores) {
  const Evidence evidence = drawEvidence(6, 3);
  ScoredTeam team({std::vector<std::optional<Isometry3d>>(6), 0}, evidence);
  for (size_t k = 0; k < 6; k++) {
    const double before = team.score();
    const double gain = Addition(k, at(0, 0), team, -1e9).gain(team);
    team.place(k, at(0, 0));
    EXPECT_NEAR(team.score() - before, gain, 1e-9) << k;
  }
  const double all = team.score();
  team.remove(2);
  team.place(2, at(0, 0));
  EXPECT_NEAR(team.score(), all, 1e-9);
}

}  // namespace
}  // namespace mrpt::fusion::test::scored_team_test
