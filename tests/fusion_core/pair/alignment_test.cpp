// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of all steps from two prepared maps to a pose and a verdict. */
#include <gtest/gtest.h>
#include <mrpt/fusion/alignment.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>
#include <string>
#include <vector>

#include "fusion_base/error_text.h"
#include "fusion_core/pair/match.h"
#include "fusion_core/pair/verify.h"
#include "fusion_core/verdict/evaluation.h"
#include "support/prepared_apartment.h"

namespace mrpt::fusion::test::alignment_test {
namespace {

class Aligning : public WithPreparedApartment {
 protected:
  static const PreparedMap& edgesOfB() {
    static const PreparedMap edges(maps().b.edges);
    return edges;
  }
  /** The match of a guess near the truth. */
  static const Alignment& found() {
    static const Alignment alignment = align(a(), b(), near(poseOf(0.3, -0.2, 0, 4)), {});
    return alignment;
  }
  /** A guess that is off by so much. */
  static Prior near(const Eigen::Isometry3d& off) {
    return Prior::near(toPose(maps().truth * off));
  }

  /** What is said if maps cannot be matched. */
  template <class F>
  static std::string errorOf(F&& f) {
    try {
      f();
    } catch (const std::exception& e) {
      return messageOf(e);
    }
    return {};
  }

  /** Farther off than refining goes. */
  const Eigen::Isometry3d wrong = truth * poseOf(3, 1, 0, 25);
};

// ---------------------------------------------------------------- pose and verdict

TEST_F(Aligning, FindsThePoseAndAcceptsIt) {
  for (const Prior& prior : {near(poseOf(0.3, -0.2, 0, 4)), Prior::none()}) {
    const Alignment r = align(a(), b(), prior, {});
    EXPECT_LT(metresBetween(r.match.T_a_b, truth), 0.1);
    EXPECT_LT(degreesBetween(r.match.T_a_b, truth), 1);
    EXPECT_TRUE(r.evaluation.accepted);
    EXPECT_FALSE(r.by_edges);
  }
}

TEST_F(Aligning, TellsTheSizesOfBothMaps) {
  EXPECT_EQ(found().voxels_a, a().occupiedVoxels());
  EXPECT_EQ(found().voxels_b, b().occupiedVoxels());
  EXPECT_EQ(found().edges_a, a().edges().size());
  EXPECT_EQ(found().edges_b, b().edges().size());
  EXPECT_NE(found().voxels_a, found().voxels_b);
  EXPECT_GT(found().seconds_matching, 0);
  EXPECT_GT(found().seconds_evaluation, 0);
}

TEST_F(Aligning, PoseIsAViewOfTheMatch) {
  const auto pose = found().pose();
  EXPECT_TRUE(toEigen(pose.mean).isApprox(found().match.T_a_b, 1e-12));
  EXPECT_TRUE(pose.cov.asEigen().isApprox(
      toYawPitchRollCovariance(found().match.covariance, found().match.T_a_b), 1e-12));
}

TEST_F(Aligning, HypothesesAreAViewOfTheMatch) {
  const auto modes = found().hypotheses();
  const auto& expected = found().match.hypotheses;
  ASSERT_GE(expected.size(), 2U);
  ASSERT_EQ(modes.size(), expected.size());
  auto mode = modes.begin();
  for (const RankedPose& h : expected) {
    EXPECT_TRUE(toEigen(mode->val.mean).isApprox(h.T_a_b, 1e-12));
    EXPECT_NEAR(mode->log_w, std::log(h.agreement), 1e-12);
    EXPECT_TRUE(
        mode->val.cov.asEigen().isApprox(toYawPitchRollCovariance(h.covariance, h.T_a_b), 1e-12));
    ++mode;
  }
}

TEST_F(Aligning, ViewsFollowTheMatch) {
  Alignment changed = found();
  changed.match.T_a_b = poseOf(1, 2, 3, 40);
  changed.match.hypotheses.resize(2);
  EXPECT_TRUE(toEigen(changed.pose().mean).isApprox(poseOf(1, 2, 3, 40), 1e-12));
  EXPECT_EQ(changed.hypotheses().size(), 2U);
  changed.match.hypotheses[1].agreement = 0;
  EXPECT_EQ(changed.hypotheses().size(), 1U) << "no mode has a weight of zero";
  changed.match.hypotheses.clear();
  EXPECT_EQ(changed.hypotheses().size(), 0U);
}

TEST_F(Aligning, TellsOfEachIteration) {
  std::vector<IterationRecord> told;
  const Alignment r = align(a(), b(), near(poseOf(0.3, -0.2, 0, 4)), {},
                            [&](const IterationRecord& i) { told.push_back(i); });
  ASSERT_FALSE(told.empty());
  ASSERT_EQ(told.size(), r.match.iterations.size());
  for (size_t i = 0; i < told.size(); i++)
    EXPECT_EQ(told[i].T_a_b.matrix(), r.match.iterations[i].T_a_b.matrix());
}

// ---------------------------------------------------------------- judge and verify

TEST_F(Aligning, TheVerdictIsThatOfTheMatch) {
  const Evaluation e = judge(a().features(), b().features(), found().match, Options().evaluation);
  EXPECT_EQ(e.probability, found().evaluation.probability);
  EXPECT_EQ(e.reasons, found().evaluation.reasons);
}

TEST_F(Aligning, JudgingNeitherSearchesNorChangesTheMatch) {
  const Options options = credulous();
  const MatchResult match = matchAt(a().features(), b().features(), wrong, options);
  const MatchResult before = match;
  const Evaluation e = judge(a().features(), b().features(), match, options.evaluation);
  EXPECT_TRUE(e.accepted);
  EXPECT_LT(e.probability, options.evaluation.sure_probability);
  EXPECT_EQ(e.runner_up, 0);
  EXPECT_EQ(match.T_a_b.matrix(), before.T_a_b.matrix());
  EXPECT_EQ(match.covariance, before.covariance);
  EXPECT_EQ(match.pairs.size(), before.pairs.size());
  EXPECT_TRUE(match.hypotheses.empty());
}

TEST_F(Aligning, VerifyingSearchesEverywhereIfTheVerdictIsNotSure) {
  const Options options = credulous();
  MatchResult match = matchAt(a().features(), b().features(), wrong, options);
  const Evaluation e = verify(a().features(), b().features(), options, match);
  EXPECT_FALSE(e.accepted);
  EXPECT_GT(e.runner_up, 1);
  EXPECT_EQ(match.T_a_b.matrix(), wrong.matrix()) << "the match stays what it is";
  ASSERT_EQ(match.hypotheses.size(), 2U);
  EXPECT_LT(metresBetween(match.hypotheses[1].T_a_b, truth), 0.1) << "the better pose";
  EXPECT_EQ(e.other_poses, OtherPoses::Compared);
}

TEST_F(Aligning, VerifyingNamesTheBetterPoseOfARejectedPose) {
  Options strict = credulous();
  strict.evaluation.min_probability = 0.99;
  // Maps that do not touch have no agreement: any other pose is better.
  for (const Eigen::Isometry3d& pose : {wrong, Eigen::Isometry3d(poseOf(500, 0, 0, 0))}) {
    MatchResult match = matchAt(a().features(), b().features(), pose, strict);
    const Evaluation e = verify(a().features(), b().features(), strict, match);
    EXPECT_FALSE(e.accepted);
    EXPECT_GT(e.runner_up, 1);
    EXPECT_LE(e.runner_up, MatchResult::kMostRunnerUp);
    EXPECT_EQ(e.probability,
              judge(a().features(), b().features(), match, strict.evaluation).probability);
    ASSERT_EQ(match.hypotheses.size(), 2U);
    EXPECT_LT(metresBetween(match.hypotheses[1].T_a_b, truth), 0.1);
    const bool is_named = std::any_of(e.reasons.begin(), e.reasons.end(), [](const auto& reason) {
      return reason.find("another pose [") == 0;
    });
    EXPECT_TRUE(is_named);
  }
}

TEST_F(Aligning, VerifyingDoesNotSearchIfItIsNotToOrNeedNot) {
  Options never = credulous(), no_search = credulous(), everywhere_already = credulous();
  never.evaluation.sure_probability = 0;
  no_search.search.translation = 0;
  everywhere_already.search = everywhere(everywhere_already.search);
  for (const Options& options : {never, no_search, everywhere_already}) {
    MatchResult match = matchAt(a().features(), b().features(), wrong, options);
    const Evaluation e = verify(a().features(), b().features(), options, match);
    EXPECT_TRUE(e.accepted);
    EXPECT_TRUE(match.hypotheses.empty());
    EXPECT_EQ(e.other_poses, OtherPoses::NotSearched);
  }
}

TEST_F(Aligning, VerifyingARightMatchLeavesItAccepted) {
  Options never_sure;
  never_sure.evaluation.sure_probability = 1;
  MatchResult match = found().match;
  const Evaluation e = verify(a().features(), b().features(), never_sure, match);
  EXPECT_TRUE(e.accepted);
  EXPECT_EQ(match.hypotheses.size(), found().match.hypotheses.size());
  MatchResult given = matchAt(a().features(), b().features(), truth, never_sure);
  EXPECT_EQ(verify(a().features(), b().features(), never_sure, given).other_poses,
            OtherPoses::NoneBetter);
}

// ---------------------------------------------------------------- a given pose

TEST_F(Aligning, AGivenPoseIsJudgedAsItIs) {
  const Alignment right = evaluate(a(), b(), toPose(truth), {});
  EXPECT_TRUE(right.evaluation.accepted);
  EXPECT_TRUE(right.match.T_a_b.isApprox(truth, 1e-12));
  EXPECT_TRUE(right.match.hasPairs());
  EXPECT_TRUE(right.match.iterations.empty());
  EXPECT_EQ(right.voxels_b, b().occupiedVoxels());
  const Alignment off = evaluate(a(), b(), toPose(truth * poseOf(1, 0, 0, 0)), {});
  EXPECT_FALSE(off.evaluation.accepted);
  EXPECT_LT(off.evaluation.probability, right.evaluation.probability);
}

// ---------------------------------------------------------------- maps of other kinds

/** Returns a map with the same voxels, each \a factor times as wide; without free space if not
 * \a keeps_free. */
octomap::OcTree rescaled(const octomap::OcTree& map, double factor, bool keeps_free = true) {
  octomap::OcTree result(factor * map.getResolution());
  octomap::OcTree whole(map);
  whole.expand();
  for (auto leaf = whole.begin_leafs(); leaf != whole.end_leafs(); ++leaf)
    if (keeps_free || whole.isNodeOccupied(*leaf))
      result.setNodeValue(leaf.getKey(), 0.F, true)->setLogOdds(leaf->getLogOdds());
  result.updateInnerOccupancy();
  result.prune();
  return result;
}

TEST_F(Aligning, AcceptsTheSameMapsAtLargerVoxels) {
  constexpr double kFactor = 5;  // voxels of 1 m
  const PreparedMap coarse_a(rescaled(*maps().map_a, kFactor)),
      coarse_b(rescaled(*maps().map_b, kFactor));
  const Alignment r = align(coarse_a, coarse_b, Prior::none(), {});
  const Alignment plain = align(a(), b(), Prior::none(), {});
  EXPECT_EQ(plain.scale, 1);
  EXPECT_EQ(r.scale, kFactor);
  Eigen::Isometry3d expected = truth;
  expected.translation() *= kFactor;
  EXPECT_LT(metresBetween(r.match.T_a_b, expected), 0.2 * kFactor);
  EXPECT_LT(degreesBetween(r.match.T_a_b, expected), 1);
  EXPECT_EQ(r.evaluation.accepted, plain.evaluation.accepted);
  EXPECT_NEAR(r.evaluation.probability, plain.evaluation.probability, 0.02);

  Options metres;
  metres.features.scale.fixed = 1;
  EXPECT_FALSE(align(PreparedMap(*coarse_a.octree(), metres.features),
                     PreparedMap(*coarse_b.octree(), metres.features), Prior::none(), metres)
                   .evaluation.accepted);
}

TEST_F(Aligning, WithoutFreeSpaceSaysSoAndCountsMissedObstacles) {
  const PreparedMap cloud_a(rescaled(*maps().map_a, 1, false)),
      cloud_b(rescaled(*maps().map_b, 1, false));
  const auto right = evaluate(cloud_a, cloud_b, toPose(truth), {}).evaluation;
  const auto moved = evaluate(cloud_a, cloud_b, toPose(wrong), {}).evaluation;
  for (const Evaluation& e : {right, moved}) {
    EXPECT_EQ(e.without_free_space, 1);
    EXPECT_EQ(e.free_space.conflicting, 0U);
    EXPECT_EQ(e.free_space.agreeing, e.free_space.agreeing_without_free);
    std::string all;
    for (const auto& reason : e.reasons) all += reason + "\n";
    EXPECT_NE(all.find("neither map has free space"), std::string::npos) << all;
  }
  EXPECT_LT(right.free_space.missedRatio(), 0.1);
  EXPECT_GT(moved.free_space.missedRatio(), 3 * right.free_space.missedRatio());

  const auto one_sided = evaluate(a(), cloud_b, toPose(truth), {}).evaluation;
  EXPECT_EQ(one_sided.without_free_space, 0.5);
  EXPECT_GT(one_sided.free_space.agreeing, one_sided.free_space.agreeing_without_free);
  EXPECT_GT(one_sided.free_space.agreeing_without_free, 0U);
  EXPECT_EQ(evaluate(a(), b(), toPose(truth), {}).evaluation.free_space.missed, 0U);
}

// ---------------------------------------------------------------- edges alone

TEST_F(Aligning, EdgesAloneTellWhereTheMapsMeet) {
  const Alignment r = align(a(), edgesOfB(), near(poseOf(0.3, -0.2, 0, 4)), {});
  EXPECT_TRUE(r.by_edges);
  EXPECT_LT(metresBetween(r.match.T_a_b, truth), 0.4);
  EXPECT_EQ(r.voxels_b, edgesOfB().occupiedVoxels());
}

TEST_F(Aligning, EdgesAloneAreNeverAccepted) {
  Options options = credulous();
  options.evaluation.max_runner_up = 1;
  const PreparedMap edges_of_a(maps().a.edges);
  const Prior prior = near(poseOf(0.3, -0.2, 0, 4));
  for (const Alignment& r :
       {align(a(), edgesOfB(), prior, options), align(edges_of_a, b(), prior, options),
        align(edges_of_a, edgesOfB(), prior, options)}) {
    EXPECT_TRUE(r.by_edges);
    EXPECT_TRUE(r.match.hasPairs());
    EXPECT_FALSE(r.evaluation.accepted);
    EXPECT_FALSE(r.evaluation.is_ambiguous);
    ASSERT_GT(r.evaluation.reasons_against, 0U);
    EXPECT_NE(r.evaluation.reasons[r.evaluation.reasons_against - 1].find("edges alone"),
              std::string::npos);
  }
}

TEST_F(Aligning, SaysHowFarThePoseIsFromAWrongGuess) {
  const auto allReasons = [&](const Prior& prior) {
    std::string all;
    for (const auto& reason : align(a(), b(), prior, {}).evaluation.reasons) all += reason + "\n";
    return all;
  };
  const Prior wrong_guess = near(poseOf(40, 30, 0, 120));
  EXPECT_NE(allReasons(wrong_guess).find(" m and 120 deg from the guess"), std::string::npos)
      << allReasons(wrong_guess);
  EXPECT_EQ(allReasons(near(poseOf(0.3, -0.2, 0, 4))).find("from the guess"), std::string::npos);
}

TEST_F(Aligning, AGuessBoundsThePoseByThreeOfItsDeviations) {
  const auto guessed = [&](const Eigen::Isometry3d& off, double metres, double yaw_deg) {
    return align(a(), b(), Prior::within(toPose(off * truth), metres, M_PI / 180 * yaw_deg), {})
        .evaluation;
  };
  const Eigen::Isometry3d aside = poseOf(0.6, -0.5, 0, 0), above = poseOf(0, 0, 0.5, 0);
  const Eigen::Isometry3d turned =
      truth * Eigen::AngleAxisd(M_PI / 180 * 5, Eigen::Vector3d::UnitZ()) * truth.inverse();
  for (const auto& off : {aside, above, turned}) {
    EXPECT_TRUE(guessed(off, 0.3, 2).accepted) << off.matrix();
    const Evaluation e = guessed(off, 0.05, 0.5);
    EXPECT_FALSE(e.accepted || e.is_ambiguous) << off.matrix();
    ASSERT_FALSE(e.against().empty()) << off.matrix();
    EXPECT_NE(e.against().back().find("from the guess, whose 3 standard deviations allow"),
              std::string::npos)
        << e.against().back();
  }
}

TEST_F(Aligning, SaysThatTheMapsDoNotTouchWithinTheBoundsOfAGuess) {
  mrpt::poses::CPose3DPDFGaussian far(toPose(poseOf(300, 0, 0, 0) * truth));
  far.cov.setDiagonal(6, 0.01);
  const Evaluation e = align(a(), b(), far, {}).evaluation;
  EXPECT_FALSE(e.accepted);
  EXPECT_EQ(e.pairs, 0U);
  std::string all;
  for (const auto& reason : e.reasons) all += reason + "\n";
  EXPECT_NE(all.find("do not touch anywhere within the bounds of the guess"), std::string::npos)
      << all;
  EXPECT_EQ(all.find("slides"), std::string::npos) << all;
}

TEST_F(Aligning, EdgesAloneCannotBeJudgedAtAPose) {
  EXPECT_THROW(evaluate(a(), edgesOfB(), toPose(truth), {}), std::exception);
  EXPECT_THROW(evaluate(edgesOfB(), a(), toPose(truth), {}), std::exception);
}

// ---------------------------------------------------------------- what cannot be matched

TEST_F(Aligning, SaysWhichMapHasNoOccupiedVoxel) {
  const PreparedMap nothing(octomap::OcTree(0.2));
  const PreparedMap air(*MapWriter(0.2).box({0, 0, 0}, {9, 9, 9}, kFree).pruned());
  for (const PreparedMap& empty : {nothing, air, PreparedMap(EdgeVoxels())}) {
    EXPECT_EQ(errorOf([&] { align(empty, b(), Prior::none(), {}); }),
              "map A has no occupied voxel");
    EXPECT_EQ(errorOf([&] { align(a(), empty, Prior::none(), {}); }),
              "map B has no occupied voxel");
  }
}

TEST_F(Aligning, RefusesAGuessThatIsNoPose) {
  mrpt::poses::CPose3D guess;
  guess.x(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(errorOf([&] { align(a(), b(), Prior::near(guess), {}); }),
            "the initial guess is not a pose");
}

}  // namespace
}  // namespace mrpt::fusion::test::alignment_test
