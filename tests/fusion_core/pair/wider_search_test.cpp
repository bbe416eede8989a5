// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the searches after a match near a guess that is not sure. */
#include "fusion_core/pair/wider_search.h"

#include <gtest/gtest.h>
#include <mrpt/fusion/alignment.h>

#include "fusion_core/features/features.h"
#include "fusion_core/pair/match.h"
#include "fusion_core/verdict/evaluation.h"
#include "support/prepared_apartment.h"

namespace mrpt::fusion::test::wider_search_test {
namespace {

class SearchingWider : public WithPreparedApartment {
 protected:
  /** Returns the prior of a guess with standard deviations of position and yaw. */
  static Prior gaussian(const Eigen::Isometry3d& guess, double metres, double yaw_deg) {
    mrpt::poses::CPose3DPDFGaussian pdf(toPose(guess));
    for (int i = 0; i < 3; i++) pdf.cov(i, i) = metres * metres;
    pdf.cov(3, 3) = yaw_deg * yaw_deg * M_PI * M_PI / (180 * 180);
    return Prior::gaussian(pdf);
  }
  double error(const Alignment& r) const { return metresBetween(r.match.T_a_b, truth); }

  /** Beyond the reach of the search near a guess. */
  const Eigen::Isometry3d far_off = truth * poseOf(6, 2, 0, 90);
};

TEST_F(SearchingWider, AGuessFarOffIsNoWorseThanNoGuess) {
  Options no_wider;
  no_wider.evaluation.sure_probability = 0;
  EXPECT_GT(error(align(a(), b(), Prior::near(toPose(far_off)), no_wider)), 1);
  const Alignment none = align(a(), b(), Prior::none(), {});
  const Alignment guessed = align(a(), b(), Prior::near(toPose(far_off)), {});
  ASSERT_TRUE(none.evaluation.accepted);
  EXPECT_TRUE(guessed.evaluation.accepted);
  EXPECT_LT(error(guessed), 0.1);
}

TEST_F(SearchingWider, AGuessWhereTheMapsDoNotMeetIsNoWorseThanNoGuess) {
  const Alignment r = align(a(), b(), Prior::near(toPose(truth * poseOf(80, 0, 0, 0))), {});
  EXPECT_TRUE(r.evaluation.accepted);
  EXPECT_LT(error(r), 0.1);
}

TEST_F(SearchingWider, APoseThatTiltsTheMapIsNoPlace) {
  const SearchParams search;
  const Eigen::Isometry3d guess = poseOf(1, 2, 3, 40, 10, 5);
  for (const auto& moved :
       {poseOf(9, -5, 2, 170), poseOf(0, 0, 0, 90, 15), poseOf(0, 0, 0, 0, 0, -20)})
    EXPECT_FALSE(isTooTilted(moved * guess, guess, search)) << moved.matrix();
  for (const auto& turned : {poseOf(0, 0, 0, 0, 40), poseOf(3, 0, 0, 120, 0, -30)})
    EXPECT_TRUE(isTooTilted(turned * guess, guess, search)) << turned.matrix();
  SearchParams all_rotations;
  all_rotations.rotations = SearchRotations::All;
  EXPECT_FALSE(isTooTilted(poseOf(0, 0, 0, 0, 90) * guess, guess, all_rotations));
}

TEST_F(SearchingWider, AnAcceptedMatchThatIsNotSureGivesWayToABetterPose) {
  const Alignment r = align(a(), b(), Prior::near(toPose(far_off)), credulous());
  EXPECT_LT(error(r), 0.1);
  EXPECT_TRUE(r.evaluation.accepted);
  EXPECT_LT(r.evaluation.runner_up, 0.75) << "the match near the guess is a rival";
}

TEST_F(SearchingWider, APoseOutsideAStatedCovarianceDoesNotOverruleTheMatch) {
  const Alignment r = align(a(), b(), gaussian(far_off, 0.2, 2), credulous());
  EXPECT_GT(error(r), 1);
  // The registration has left the bounds. Nothing else rejects the match.
  const Evaluation e = judge(a().features(), b().features(), r.match, credulous().evaluation);
  EXPECT_TRUE(e.accepted);
  EXPECT_EQ(r.evaluation.reasons.size(), e.reasons.size() + 1);
  EXPECT_NE(r.evaluation.against().back().find(" from the guess"), std::string::npos);
  for (const RankedPose& h : r.match.hypotheses) EXPECT_GT(metresBetween(h.T_a_b, truth), 1);
}

TEST_F(SearchingWider, ARejectedPoseNamesTheBetterPoseElsewhere) {
  Options nothing_is_accepted;
  nothing_is_accepted.evaluation.max_free_conflict = 0;
  nothing_is_accepted.evaluation.min_probability = 1;
  const Alignment r = align(a(), b(), Prior::near(toPose(far_off)), nothing_is_accepted);
  EXPECT_FALSE(r.evaluation.accepted);
  EXPECT_LT(error(r), 0.1) << "of two rejected poses the more probable pose is the result";
}

TEST_F(SearchingWider, TheSearchesGrow) {
  const Options options;
  const auto near = widerSearches(Prior::near({}), options);
  ASSERT_EQ(near.size(), 2U);
  EXPECT_EQ(near[0].translation, options.search.translation);
  EXPECT_GT(near[0].hypotheses, options.search.hypotheses);
  EXPECT_TRUE(near[1].isEverywhere());

  const auto stated = widerSearches(gaussian(truth, 1, 5), options);
  ASSERT_EQ(stated.size(), 1U);
  EXPECT_FALSE(stated[0].isEverywhere());

  Options no_search, everywhere_already, never;
  no_search.search.translation = 0;
  everywhere_already.search = everywhere(options.search);
  never.evaluation.sure_probability = 0;
  for (const Options& o : {no_search, everywhere_already, never})
    EXPECT_TRUE(widerSearches(Prior::near({}), o).empty());
}

}  // namespace
}  // namespace mrpt::fusion::test::wider_search_test
