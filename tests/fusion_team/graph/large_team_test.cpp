// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests that the search of a team scales, on maps that are pieces of a long corridor. */
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "fusion_team/graph/team_search.h"

namespace mrpt::fusion::test::large_team_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kLength = 60, kStep = 20, kBay = 5;  // m

Isometry3d along(double x) {
  Isometry3d T = Isometry3d::Identity();
  T.translation().x() = x;
  return T;
}

/** Map k begins at kStep * k and shows kLength of the corridor, one obstacle per metre. So it
 * overlaps two maps on each side. Maps at the wrong bay confirm every second obstacle and
 * contradict some. */
class Corridor : public TeamEvidence {
 public:
  explicit Corridor(size_t maps) : maps_(maps), known_(maps * maps) {}

  static Isometry3d truth(size_t a, size_t b) { return along(kStep * (double(b) - double(a))); }

  size_t size() const override { return maps_; }
  Matrix6d covariance(size_t, size_t, const Isometry3d&) const override {
    return 1e-4 * Matrix6d::Identity();
  }
  bool isSame(size_t, const Isometry3d& T, const Isometry3d& U) const override {
    return (T.translation() - U.translation()).norm() < 0.6;
  }
  bool isSure(size_t, size_t, const Isometry3d&) const override { return false; }
  std::optional<Isometry3d> sureMatch(size_t, size_t) const override { return {}; }
  Eigen::AlignedBox3d box(size_t) const override {
    return {Vector3d(0.1, 0, 0), Vector3d(kLength - 0.1, 2, 2)};
  }
  double areaOfObstacle(size_t) const override { return 1; }
  double areaOf(size_t) const override { return kLength; }
  ConflictTolerance tolerance(size_t) const override { return {0.03, 0.01}; }
  const PairEvidence& near(size_t a, size_t b, const Isometry3d& T) const override {
    questions_++;
    const int offset = int(std::lround(T.translation().x()));
    for (const auto& [known, evidence] : known_[a * maps_ + b])
      if (known == offset) return evidence;
    computed_++;
    PairEvidence e{T, {{0}, {0}, {0}}, {{0}, {0}, {0}}};
    const bool is_right = isSame(b, T, truth(a, b));
    for (int in_a = 0; in_a < int(kLength); in_a++) {
      const int in_b = in_a - offset;
      if (in_b < 0 || in_b >= int(kLength)) continue;
      const bool is_conflict = !is_right && in_a % 10 == 0;
      if (!is_right && in_a % 2 == 1) continue;
      (is_conflict ? e.of_a.contradicted : e.of_a.confirmed)[0] |= uint64_t{1} << in_a;
      (is_conflict ? e.of_b.contradicted : e.of_b.confirmed)[0] |= uint64_t{1} << in_b;
    }
    return known_[a * maps_ + b].emplace_back(offset, e).second;
  }

  /** Returns right hypotheses of all pairs that overlap, and as many that are wrong. */
  std::vector<Way> ways() const {
    std::vector<Way> ways;
    for (size_t a = 0; a < maps_; a++)
      for (const size_t b : {a + 1, a + 2})
        if (b < maps_)
          for (const double error : {0.0, kBay, -kBay})
            ways.push_back({a, b, truth(a, b) * along(error)});
    for (size_t a = 0; a + 9 < maps_; a += 3) ways.push_back({a, a + 9, along(kStep)});
    return ways;
  }

  size_t questions() const { return questions_; }
  size_t computed() const { return computed_; }

 private:
  size_t maps_;
  mutable std::vector<std::deque<std::pair<int, PairEvidence>>> known_;  // by a and b
  mutable size_t questions_ = 0, computed_ = 0;
};

/** What the search of a team asks for. */
struct Effort {
  size_t questions, computed;
};

Effort effortOf(size_t maps) {
  const Corridor corridor(maps);
  const TeamSearchResult found = searchTeam(corridor.ways(), corridor, 24);
  for (size_t k = 0; k < maps; k++) {
    const bool is_placed = found.best.pose[k].has_value();
    EXPECT_TRUE(is_placed) << k << " of " << maps;
    if (!is_placed) continue;
    EXPECT_TRUE(
        (found.best.pose[0]->inverse() * *found.best.pose[k]).isApprox(Corridor::truth(0, k), 1e-6))
        << k << " of " << maps;
    EXPECT_LT(found.runner_up[k], 0.8) << k << " of " << maps;
  }
  return {corridor.questions(), corridor.computed()};
}

TEST(LargeTeam, TheSearchAsksOnlyForMapsThatMeet) {
  const Effort of_20 = effortOf(20), of_100 = effortOf(100);
  RecordProperty("questions_of_20", std::to_string(of_20.questions));
  RecordProperty("questions_of_100", std::to_string(of_100.questions));
  RecordProperty("computed_of_20", std::to_string(of_20.computed));
  RecordProperty("computed_of_100", std::to_string(of_100.computed));
  EXPECT_LT(of_100.computed, 8 * of_20.computed) << "the corridor is 5 times as long";
  EXPECT_LT(of_100.questions, 15 * of_20.questions) << "not 25 times, as all pairs of maps";
}

}  // namespace
}  // namespace mrpt::fusion::test::large_team_test
