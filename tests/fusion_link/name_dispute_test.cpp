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

TEST(NameDispute, ARobotAnswersAgainAfterANewSession) {
  NameDispute a(7), b(5);
  b.hear(*a.hear(b.claim(10), 500), 20);
  EXPECT_FALSE(b.newerAt() && a.newerAt());
  const auto answer = a.hear(b.claim(1000), 1500);  // what a had said before may be lost
  ASSERT_TRUE(answer);
  b.hear(*answer, 1010);
  EXPECT_EQ(b.newerAt(), 20);  // its age when it first heard of a
}

TEST(NameDispute, DamagedClaimsAreRefusedAndMemoryIsBounded) {
  const std::string bytes = toBytes(NameClaim{1, 2, 3, 4});
  EXPECT_THROW(nameClaimOf(bytes.substr(1)), std::runtime_error);
  EXPECT_THROW(nameClaimOf(bytes + "1"), std::runtime_error);
  EXPECT_THROW(nameClaimOf(toBytes(NameClaim{1, INT64_MIN, 3, 4})), std::runtime_error);
  NameDispute a(1000);
  for (uint64_t number = 1; number <= 64; number++)
    EXPECT_TRUE(a.hear(NameClaim{number, 0, 0, 0}, 0));
  EXPECT_FALSE(a.hear(NameClaim{65, 0, 0, 0}, 0));
}

}  // namespace
}  // namespace mrpt::fusion::test::name_dispute_test
