// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the dispute of robots about a name. */
#include "fusion_link/name_dispute.h"

#include <gtest/gtest.h>

#include <deque>
#include <utility>

namespace mrpt::fusion::test::name_dispute_test {
namespace {

/** A robot that started at some time. */
struct Robot {
  Robot(uint64_t number, int64_t start) : dispute(number), begin(start) {}
  NameDispute dispute;
  int64_t begin;
};

/** Lets two robots meet. \param[in] to_a, to_b Times that claims are on their way, us.
 * \return Whether each of them is the newer. */
std::pair<bool, bool> meet(Robot a, Robot b, int64_t meeting, int64_t to_a, int64_t to_b) {
  struct OnTheWay {
    Robot* to;
    int64_t arrival;
    NameClaim claim;
  };
  std::deque<OnTheWay> claims = {
      {&b, meeting + to_b, nameClaimOf(toBytes(a.dispute.claim(meeting - a.begin)))},
      {&a, meeting + to_a, nameClaimOf(toBytes(b.dispute.claim(meeting - b.begin)))}};
  int heard = 0;
  for (; !claims.empty() && heard < 100; heard++) {
    const OnTheWay next = claims.front();
    claims.pop_front();
    const auto answer = next.to->dispute.hear(next.claim, next.arrival - next.to->begin);
    const bool is_a = next.to == &a;
    if (answer) claims.push_back({is_a ? &b : &a, next.arrival + (is_a ? to_b : to_a), *answer});
  }
  EXPECT_LE(heard, 4);  // two claims and two answers
  return {a.dispute.newerAt().has_value(), b.dispute.newerAt().has_value()};
}

using Newer = std::pair<bool, bool>;

TEST(NameDispute, TheRobotThatStartedLaterIsTheNewer) {
  for (const auto& [to_a, to_b] : {std::pair<int64_t, int64_t>{10, 10}, {5000, 5000}, {10, 900}}) {
    EXPECT_EQ(meet({7, 0}, {5, 1000}, 2000, to_a, to_b), (Newer{false, true}));
    EXPECT_EQ(meet({7, 1000}, {5, 0}, 2000, to_a, to_b), (Newer{true, false}));
  }
}

TEST(NameDispute, ExactlyOneIsTheNewerWhateverTheLinkDoes) {
  for (const int64_t start : {-3, -1, 0, 1, 2})
    for (const int64_t to_a : {0, 1, 4, 50})
      for (const int64_t to_b : {0, 2, 4, 50}) {
        const auto [a, b] = meet({7, 0}, {5, start}, 100, to_a, to_b);
        EXPECT_NE(a, b) << start << " " << to_a << " " << to_b;
      }
}

TEST(NameDispute, ALostAnswerIsGivenAgainAndTheFirstMeetingCounts) {
  NameDispute a(7), b(5);
  a.hear(b.claim(5), 5);  // this answer is lost
  EXPECT_FALSE(a.newerAt() || a.isOlder());
  b.hear(*a.hear(b.claim(2'000'000), 2'000'010), 2'000'020);
  a.hear(*b.hear(a.claim(2'000'030), 2'000'040), 2'000'050);
  EXPECT_TRUE(b.isOlder());
  EXPECT_FALSE(b.newerAt());
  EXPECT_FALSE(a.isOlder());
  EXPECT_EQ(a.newerAt(), 5);  // its age when it first heard of b
}

TEST(NameDispute, AnswersToOtherRobotsAreIgnored) {
  NameDispute a(7);
  EXPECT_FALSE(a.hear(NameClaim{5, 1000, 9, -500}, 10));
  EXPECT_FALSE(a.hear(NameClaim{7, 1000, 0, 0}, 10)) << "its own claim";
  EXPECT_FALSE(a.newerAt() || a.isOlder());
}

TEST(NameDispute, ARobotThatHearsOfASurelyOlderRobotNeedsNoAnswer) {
  NameDispute a(7);
  ASSERT_TRUE(a.hear(NameClaim{5, 1000, 0, 0}, 1000));
  EXPECT_FALSE(a.newerAt());  // they may have started in the time of a claim
  a.hear(NameClaim{6, 1001, 0, 0}, 1000);
  EXPECT_EQ(a.newerAt(), 1000);
  EXPECT_TRUE(a.hasToLeave(1000));
}

TEST(NameDispute, NobodyMakesARobotLeaveThatHasRunForLong) {
  constexpr int64_t kSecond = 1'000'000;
  const NameClaim old{5, 9000 * kSecond, 7, 9000 * kSecond};
  NameDispute early(7), late(7);
  early.hear(old, 9 * kSecond);
  EXPECT_TRUE(early.hasToLeave(59 * kSecond));
  EXPECT_FALSE(early.hasToLeave(60 * kSecond));
  late.hear(old, 10 * kSecond);
  EXPECT_FALSE(late.hasToLeave(10 * kSecond));
  NameDispute met(7);
  met.hear({5, 0, 0, 0}, 9 * kSecond);  // in its first seconds, but it is answered much later
  met.hear({5, 0, 7, 9000 * kSecond}, 61 * kSecond);
  EXPECT_EQ(met.newerAt(), 9 * kSecond);
  EXPECT_FALSE(met.hasToLeave(61 * kSecond));
}

TEST(NameDispute, DamagedClaimsAreRefused) {
  const std::string bytes = toBytes(NameClaim{1, 2, 3, 4});
  EXPECT_THROW(nameClaimOf(bytes.substr(1)), std::runtime_error);
  EXPECT_THROW(nameClaimOf(bytes + "1"), std::runtime_error);
  EXPECT_THROW(nameClaimOf(toBytes(NameClaim{1, INT64_MIN, 3, 4})), std::runtime_error);
}

TEST(NameDispute, OfTooManyRobotsThoseHeardOfFirstAreForgotten) {
  NameDispute a(1000);
  for (int64_t number = 1; number <= 65; number++) {
    const auto answer = a.hear(NameClaim{static_cast<uint64_t>(number), 0, 0, 0}, number);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->lead, number);
  }
  EXPECT_EQ(a.hear(NameClaim{2, 0, 0, 0}, 100)->lead, 2);    // remembered
  EXPECT_EQ(a.hear(NameClaim{1, 0, 0, 0}, 100)->lead, 100);  // forgotten
}

}  // namespace
}  // namespace mrpt::fusion::test::name_dispute_test
