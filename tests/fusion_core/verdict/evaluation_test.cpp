// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/verdict/evaluation.h"

#include <gtest/gtest.h>
#include <mrpt/fusion/evaluation.h>

#include <cmath>

#include "fusion_core/map/free_space.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_core/registration/pose_covariance.h"
#include "fusion_core/verdict/deviation_text.h"
#include "support/matching_tools.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::evaluation_test {
namespace {

// ---------------------------------------------------------------- eqs. (24), (25), thresholds

TEST(MahalanobisDistance, ByHand) {
  EXPECT_DOUBLE_EQ(mahalanobisDistance(1, 1, 1), std::sqrt(0.5));
  EXPECT_DOUBLE_EQ(mahalanobisDistance(0.36, 0.5, 0.25), std::sqrt(0.06));
  EXPECT_EQ(mahalanobisDistance(0, 0.7, 0.9), 0);
}

TEST(MahalanobisDistance, OfTwoTenthsIsThreeVoxelsOfTenCentimetres) {
  EXPECT_NEAR(mahalanobisDistance(0.287 * 0.287, 0.97, 0.97), 0.2, 1e-3);
}

TEST(Overlap, ByHand) {
  EXPECT_DOUBLE_EQ(overlapOf(30, 100, 50), 0.5 * (0.3 + 0.6));
  EXPECT_DOUBLE_EQ(overlapOf(50, 50, 50), 1);
  EXPECT_EQ(overlapOf(0, 10, 10), 0);
  EXPECT_EQ(overlapOf(0, 0, 10), 0);
  EXPECT_EQ(overlapOf(0, 10, 0), 0);
}

TEST(Overlap, IsAtMostOneIfManyVoxelsShareAPartner) { EXPECT_EQ(overlapOf(100, 50, 100), 1); }

TEST(AcceptanceThreshold, IsThatOfThePapersFigure9) {
  EXPECT_DOUBLE_EQ(acceptanceThreshold(0.4), 0.7);
}

TEST(AcceptanceThreshold, IsConstantBelowAndAboveAndLinearBetween) {
  EXPECT_DOUBLE_EQ(acceptanceThreshold(0), 0.8);
  EXPECT_DOUBLE_EQ(acceptanceThreshold(0.1), 0.8);
  EXPECT_DOUBLE_EQ(acceptanceThreshold(0.2), 0.8);
  EXPECT_DOUBLE_EQ(acceptanceThreshold(0.3), 0.75);
  EXPECT_NEAR(acceptanceThreshold(0.6), 0.6, 1e-12);
  EXPECT_DOUBLE_EQ(acceptanceThreshold(0.7), 0.6);
  EXPECT_DOUBLE_EQ(acceptanceThreshold(1), 0.6);
}

// ---------------------------------------------------------------- free space

/** Air, 16 voxels each way (one pruned leaf but for what stands in it), a wall at x = 12 and a lone
 * obstacle at (4, 4, 4). All else is unknown. */
std::unique_ptr<octomap::OcTree> airAndWall() {
  return MapWriter()
      .box({0, 0, 0}, {15, 15, 15}, kFree)
      .box({12, 0, 0}, {12, 15, 15}, kOccupied)
      .voxel({4, 4, 4}, kOccupied)
      .pruned();
}

FreeSpaceCheck check(const OccupiedVoxels& scene, const Eigen::Isometry3d& T) {
  const auto model = airAndWall();
  return checkFreeSpace(MapVoxels(borrowed(*model)), scene, T);
}

FreeSpaceCheck checkAt(const std::vector<Cell>& cells, const Eigen::Isometry3d& T = kIdentity) {
  return check(voxelsAt(cells, 0.1), T);
}

void expectCheck(const FreeSpaceCheck& check, size_t agreeing, size_t conflicting) {
  EXPECT_EQ(check.agreeing, agreeing);
  EXPECT_EQ(check.conflicting, conflicting);
}

TEST(FreeSpace, ObstacleInTheOthersAirConflicts) {
  expectCheck(checkAt({{8, 8, 8}, {1, 14, 3}}), 0, 2);
}

TEST(FreeSpace, ObstacleOnTheOthersObstacleAgrees) {
  expectCheck(checkAt({{12, 8, 8}, {4, 4, 4}}), 2, 0);
}

TEST(FreeSpace, ObstacleBesideTheOthersObstacleAgrees) {
  // Across a face, an edge and a corner; two voxels away it conflicts.
  expectCheck(checkAt({{11, 8, 8}, {3, 5, 4}, {5, 5, 3}}), 3, 0);
  expectCheck(checkAt({{10, 8, 8}, {4, 4, 6}, {6, 6, 6}}), 0, 3);
}

TEST(FreeSpace, ObstacleAtTheBorderOfTheFreeSpaceConflictsInPart) {
  const FreeSpaceCheck inside = checkAt({{12, 8, 8}, {8, 8, 8}});
  EXPECT_EQ(inside.discount, 0);
  EXPECT_EQ(inside.conflictRatio(), 0.5);
  const FreeSpaceCheck at_border = checkAt({{12, 8, 8}, {8, 8, 15}});
  expectCheck(at_border, 1, 1);
  const double weight = BorderParams{}.weight;
  EXPECT_EQ(at_border.discount, 1 - weight);
  EXPECT_EQ(at_border.conflictRatio(), weight / (1 + weight));
}

TEST(FreeSpace, ObstacleInUnknownSpaceSaysNothing) {
  expectCheck(checkAt({{30, 8, 8}, {-5, 0, 0}, {8, 8, 17}}), 0, 0);
  EXPECT_EQ(checkAt({{30, 8, 8}}).conflictRatio(), 0);
}

TEST(FreeSpace, ObstacleBeyondTheOctreesReachSaysNothing) {
  expectCheck(checkAt({{8, 8, 8}}, poseOf(1e6, 0, 0, 0)), 0, 0);
}

TEST(FreeSpace, IsLookedUpWhereThePosePutsTheObstacle) {
  // In the scene's frame it lies 5 m away, a quarter turn round.
  const Eigen::Isometry3d T = poseOf(5, -1, 0.3, 90);
  const Eigen::Vector3d wall = T.inverse() * centreOf({12, 8, 8}, 0.1);
  const Eigen::Vector3d air = T.inverse() * centreOf({8, 8, 8}, 0.1);
  OccupiedVoxels scene;
  scene.centre = {wall.cast<float>(), air.cast<float>(), air.cast<float>()};
  scene.probability.assign(3, 0.9F);
  const FreeSpaceCheck found = check(scene, T);
  expectCheck(found, 1, 2);
  EXPECT_DOUBLE_EQ(found.conflictRatio(), 2 / 3.0);
}

// ---------------------------------------------------------------- the verdict

/** Each of the other criteria is tested by itself. */
EvaluationParams otherThanProbability() {
  EvaluationParams params;
  params.min_probability = 0;
  return params;
}

/** Two maps, hand-made pairs of their voxels, and what evaluateMatch() says of them. */
struct Case {
  std::unique_ptr<octomap::OcTree> map_a, map_b;
  MapVoxels a{borrowed(*map_a)}, b{borrowed(*map_b)};
  Eigen::Isometry3d T_a_b = kIdentity;
  EvaluationParams params = otherThanProbability();

  Evaluation with(const Pairs& pairs) const { return evaluateMatch(a, b, pairs, T_a_b, params); }
  /** The i-th of a with the i-th of b, so many at a distance, the rest at none. */
  Evaluation withPairs(uint32_t n, uint32_t apart, float distance) const {
    Pairs pairs;
    for (uint32_t i = 0; i < n; i++) pairs.push_back({i, i, i < apart ? distance * distance : 0});
    return with(pairs);
  }
};

/** A wall of 100 voxels, p = 0.5 (so that eq. (24)'s variance is 4), and nothing else. */
std::unique_ptr<octomap::OcTree> wall() {
  return MapWriter().box({0, 0, 0}, {0, 9, 9}, 0.F).pruned();
}

/** Says the reasons as one text. */
std::string reasonsOf(const Evaluation& e) {
  std::string text;
  for (const auto& r : e.reasons) text += r + "\n";
  return text;
}

TEST(EvaluateMatch, FiguresByHand) {
  const Case c{wall(), wall()};
  ASSERT_EQ(c.a.voxels.size(), 100);
  // 40 pairs: 10 of them 0.5 m apart, that is 0.25 by eq. (24).
  const Evaluation e = c.withPairs(40, 10, 0.5F);
  EXPECT_EQ(e.pairs, 40);
  EXPECT_EQ(e.inliers, 30);
  EXPECT_DOUBLE_EQ(e.inlier_ratio, 0.75);
  EXPECT_DOUBLE_EQ(e.overlap, 0.4);
  EXPECT_DOUBLE_EQ(e.threshold, 0.7);
  EXPECT_NEAR(e.mean_mahalanobis, 0.25 / 4, 1e-6);
  EXPECT_NEAR(e.log_likelihood, -10 * 0.0625, 1e-6);
  EXPECT_EQ(e.free_space.agreeing, 200);  // both ways
  EXPECT_EQ(e.free_space.conflicting, 0);
  EXPECT_TRUE(e.accepted);
  EXPECT_EQ(e.reasons.size(), 4);
  EXPECT_NE(e.reasons[1].find("which the settings do not test"), std::string::npos) << reasonsOf(e);
}

TEST(EvaluateMatch, RejectsDust) {
  const auto voxelsEach = [](int step) {
    MapWriter writer;
    for (int y = 0; y < 10; y++)
      for (int z = 0; z < 10; z++)
        writer.box({0, step * y, step * z}, {0, step * y, step * z}, 0.F);
    return writer.pruned();
  };
  const Case dust{voxelsEach(3), wall()}, wall_of_voxels{voxelsEach(1), wall()};
  const Evaluation e = dust.withPairs(90, 0, 0);
  EXPECT_FALSE(e.accepted || e.is_ambiguous);
  EXPECT_NE(reasonsOf(e).find("100.0 % of the occupied voxels of map A touch no other"),
            std::string::npos)
      << reasonsOf(e);
  EXPECT_EQ(reasonsOf(e).find("map B touch"), std::string::npos) << reasonsOf(e);
  EXPECT_TRUE(wall_of_voxels.withPairs(90, 0, 0).accepted);
}

TEST(EvaluateMatch, InlierRatioMustExceedItsThreshold) {
  const Case c{wall(), wall()};
  EXPECT_TRUE(c.withPairs(10, 1, 0.5F).accepted);   // 0.9 > 0.8
  EXPECT_FALSE(c.withPairs(10, 2, 0.5F).accepted);  // 0.8, not more
  EXPECT_TRUE(c.withPairs(80, 31, 0.5F).accepted);  // 0.6125 > 0.6
  const Evaluation e = c.withPairs(80, 33, 0.5F);   // 0.5875
  EXPECT_FALSE(e.accepted);
  EXPECT_NE(reasonsOf(e).find("inlier ratio 58.8 % is not above its threshold 60.0 %"),
            std::string::npos)
      << reasonsOf(e);
}

TEST(EvaluateMatch, AnInlierIsBelowTheDistanceOfItsParameter) {
  Case c{wall(), wall()};
  c.params.inlier_mahalanobis = 0.26;
  EXPECT_EQ(c.withPairs(10, 5, 0.5F).inliers, 10);
  c.params.inlier_mahalanobis = 0.24;
  EXPECT_EQ(c.withPairs(10, 5, 0.5F).inliers, 5);
}

TEST(EvaluateMatch, ASecondPoseNearlyAsGoodMakesItAmbiguous) {
  Case c{wall(), wall()};
  c.params.max_runner_up = 0.5;
  const auto judged = [&](double runner_up) {
    const Pairs good = {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {3, 3, 0}, {4, 4, 0}};
    return evaluateMatch(c.a, c.b, good, c.T_a_b, c.params, {runner_up, {}});
  };
  EXPECT_TRUE(judged(0.5).accepted);
  EXPECT_FALSE(judged(0.5).is_ambiguous);
  EXPECT_FALSE(judged(0.51).accepted);
  EXPECT_TRUE(judged(0.51).is_ambiguous);
  EXPECT_EQ(judged(0.51).runner_up, 0.51);
  EXPECT_EQ(judged(0.51).reasons.size(), judged(0).reasons.size() + 1);
  EXPECT_NE(
      reasonsOf(judged(0.51))
          .find("another pose reaches 51.0 % of the agreement of this pose, more than 50.0 %"),
      std::string::npos);
  const auto named = [&](double ratio) {
    const Rival rival{ratio, poseOf(1, 2, 3, 40)};
    return reasonsOf(evaluateMatch(c.a, c.b, {{0, 0, 0}}, c.T_a_b, c.params, rival));
  };
  EXPECT_NE(named(0.51).find("another pose [1.00 2.00 3.00 40.0 "), std::string::npos);
  EXPECT_NE(named(2).find("another pose [1.00 2.00 3.00 40.0 "), std::string::npos);
  EXPECT_NE(named(2).find("this pose reaches only 50.0 % of its agreement"), std::string::npos);
  // No more if it would be rejected without that pose.
  const double alone = judged(0).probability;
  c.params.min_probability = alone;
  EXPECT_TRUE(judged(0.51).is_ambiguous);
  c.params.min_probability = std::nextafter(alone, 1.0);
  EXPECT_FALSE(judged(0.51).is_ambiguous);
  c.params.min_probability = 0;
  c.params.min_overlap = 0.06;
  EXPECT_FALSE(judged(0.51).is_ambiguous);
}

TEST(EvaluateMatch, ARivalThatConfirmsNextToNothingCountsLess) {
  Case c{wall(), wall()};
  c.params.min_rival_support = 0.2;
  const Pairs good = {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {3, 3, 0}, {4, 4, 0}};
  const auto judged = [&](double ratio, const Eigen::Isometry3d& rival) {
    return evaluateMatch(c.a, c.b, good, c.T_a_b, c.params, {ratio, rival});
  };
  // Beside each other the maps confirm one column of 10 obstacles, both ways.
  const Eigen::Isometry3d beside = poseOf(0, 1, 0, 0), on_it = poseOf(0, 0.5, 0, 0);
  const Evaluation e = judged(0.9, beside);
  ASSERT_EQ(e.free_space.agreeing, 200);
  EXPECT_DOUBLE_EQ(e.rival_support, 0.1);
  EXPECT_DOUBLE_EQ(e.rival_weight, 0.45);
  EXPECT_TRUE(e.accepted);
  EXPECT_NE(reasonsOf(e).find("It confirms only 10.0 % of the obstacles that this pose confirms, "
                              "so its agreement counts 0.5 times: 45.0 %, at"),
            std::string::npos)
      << reasonsOf(e);
  const Evaluation of_rival = judged(0.9, on_it);
  EXPECT_GT(of_rival.rival_support, 0.5);
  EXPECT_EQ(of_rival.rival_weight, 0.9);
  EXPECT_FALSE(of_rival.accepted);
  EXPECT_GT(e.probability, of_rival.probability);
  EXPECT_FALSE(judged(1.1, beside).accepted) << "it agrees better";
}

TEST(EvaluateMatch, ARivalFromTheOtherSideCountsLess) {
  Case c{wall(), wall()};
  c.params.min_rival_support = 0.2;
  c.params.other_side_rival = 0.4;
  const Pairs good = {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {3, 3, 0}, {4, 4, 0}};
  const auto judged = [&](double ratio, double same_side) {
    const Rival rival{ratio, c.T_a_b, [=] { return same_side; }};
    return evaluateMatch(c.a, c.b, good, c.T_a_b, c.params, rival);
  };
  EXPECT_EQ(judged(0.9, 0.2).rival_weight, 0.9);
  EXPECT_NEAR(judged(0.9, 0.1).rival_weight, 0.7 * 0.9, 1e-12) << "half of the way";
  const Evaluation none = judged(0.9, 0);
  EXPECT_EQ(none.rival_support, 1);
  EXPECT_EQ(none.rival_same_side, 0);
  EXPECT_NEAR(none.rival_weight, 0.4 * 0.9, 1e-12);
  EXPECT_TRUE(none.accepted);
  EXPECT_NE(reasonsOf(none).find("It confirms only 0.0 % of the obstacles that this pose confirms "
                                 "from the same side, so its agreement counts 0.4 times: 36.0 %"),
            std::string::npos)
      << reasonsOf(none);
  EXPECT_EQ(judged(1.1, 0).rival_weight, 1.1) << "it agrees better";
}

TEST(Judge, ARoomBackToBackIsARivalFromTheOtherSide) {
  const auto room = [] {
    std::shared_ptr<const octomap::OcTree> tree = MapWriter()
                                                      .box({0, 0, 0}, {19, 19, 19}, kOccupied)
                                                      .box({1, 1, 1}, {18, 18, 18}, kFree)
                                                      .pruned();
    return computeFeatures(tree, FeatureParams());
  };
  const MapFeatures a = room(), b = room();
  MatchResult match;
  const auto of = [&](const Eigen::Isometry3d& rival) {
    match.hypotheses = {{kIdentity, 1, Matrix6d::Identity()}, {rival, 0.7, Matrix6d::Identity()}};
    return judge(a, b, match, EvaluationParams());
  };
  const Evaluation back_to_back = of(poseOf(2, 0, 0, 0));
  EXPECT_GT(back_to_back.rival_support, 0.1);
  EXPECT_LT(back_to_back.rival_same_side, 0.02);
  EXPECT_LT(back_to_back.rival_weight, 0.3);
  const Evaluation turned = of(poseOf(2, 0, 0, 90));
  EXPECT_GT(turned.rival_same_side, 0.9) << "the same room";
  EXPECT_EQ(turned.rival_weight, 0.7);
}

TEST(EvaluateMatch, IsRejectedBelowTheLeastProbability) {
  Case c{wall(), wall()};
  const Evaluation e = c.withPairs(100, 0, 0);
  EXPECT_EQ(e.probability, VerdictModel().probability(1, 0, 0, 1));
  c.params.min_probability = e.probability;
  EXPECT_TRUE(c.withPairs(100, 0, 0).accepted);
  c.params.min_probability = std::nextafter(e.probability, 1.0);
  EXPECT_FALSE(c.withPairs(100, 0, 0).accepted);
  EXPECT_NE(reasonsOf(c.withPairs(100, 0, 0)).find("right with a probability of"),
            std::string::npos);
}

TEST(EvaluateMatch, ProbabilityFallsWithWhatSpeaksAgainstThePose) {
  const double good = VerdictModel().probability(0.5, 0.01, 0.01, 0.96);
  EXPECT_GT(good, 0.95);
  EXPECT_LT(VerdictModel().probability(0.05, 0.01, 0.01, 0.96), good);
  EXPECT_LT(VerdictModel().probability(0.5, 0.10, 0.01, 0.96), good);
  EXPECT_LT(VerdictModel().probability(0.5, 0.01, 0.60, 0.96), good);
  EXPECT_LT(VerdictModel().probability(0.5, 0.01, 0.01, 0.80), good);
  // A row of pillars off: all but as good, beside as good a shift by another.
  EXPECT_LT(VerdictModel().probability(0.8, 0.036, 0.6, 0.955), 0.8);
  EXPECT_GE(VerdictModel().probability(0, 1, 1, 0), 0);
}

TEST(EvaluateMatch, OverlapDoesNotHangOnTheSizesOfTheVoxels) {
  const auto whole = [] { return MapWriter(0.1).box({0, 0, 0}, {0, 19, 9}, 0.F).pruned(); };
  const auto half = [] { return MapWriter(0.05).box({0, 0, 0}, {1, 19, 19}, 0.F).pruned(); };
  const auto overlap = [](const Case& c, uint32_t n) {
    Pairs pairs;
    for (uint32_t i = 0; i < n; i++) pairs.push_back({0, i, 0});
    return c.with(pairs).overlap;
  };
  const Case fine_scene{whole(), half()}, fine_model{half(), whole()};
  ASSERT_EQ(fine_scene.b.voxels.size(), 800);
  EXPECT_DOUBLE_EQ(overlap(fine_scene, 800), 0.75);
  EXPECT_DOUBLE_EQ(overlap(fine_scene, 400), 0.375);
  EXPECT_DOUBLE_EQ(overlap(fine_model, 100), 0.75);
}

TEST(EvaluateMatch, ReasonsAgainstThePoseComeFirst) {
  Case c{wall(), wall()};
  c.params.max_runner_up = 0.5;
  const Evaluation e =
      evaluateMatch(c.a, c.b, {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}}, c.T_a_b, c.params, {0.6, {}});
  ASSERT_EQ(e.reasons.size(), 5U) << reasonsOf(e);
  ASSERT_EQ(e.reasons_against, 3U) << reasonsOf(e);
  EXPECT_NE(e.reasons[0].find("neither map has free space"), std::string::npos) << reasonsOf(e);
  EXPECT_NE(e.reasons[1].find("another pose"), std::string::npos) << reasonsOf(e);
  EXPECT_NE(e.reasons[2].find("which the settings do not test"), std::string::npos) << reasonsOf(e);
  EXPECT_NE(e.reasons[3].find("overlap"), std::string::npos) << reasonsOf(e);
  EXPECT_EQ(c.with({{0, 0, 0}, {1, 1, 0}, {2, 2, 0}}).reasons_against, 2U);
}

TEST(EvaluateMatch, AFigureAndItsLimitReadDifferently) {
  Case c{wall(), wall()};
  c.params.max_runner_up = 0.75;
  const Evaluation e =
      evaluateMatch(c.a, c.b, {{0, 0, 0}, {1, 1, 0}}, c.T_a_b, c.params, {0.75004, {}});
  EXPECT_NE(reasonsOf(e).find("reaches 75.004 % of"), std::string::npos) << reasonsOf(e);
}

TEST(EvaluateMatch, TooLittleOverlapIsRejectedHoweverGoodItLooks) {
  Case c{wall(), wall()};
  EXPECT_TRUE(c.withPairs(2, 0, 0).accepted);  // 2 %
  const Evaluation e = c.withPairs(1, 0, 0);
  EXPECT_FALSE(e.accepted);
  EXPECT_NE(reasonsOf(e).find("overlap 1.0 % is below 2.0 %"), std::string::npos) << reasonsOf(e);
  c.params.min_overlap = 0.005;
  EXPECT_TRUE(c.withPairs(1, 0, 0).accepted);
}

TEST(EvaluateMatch, WithoutPairsIsRejected) {
  Case c{wall(), wall()};
  c.params.min_overlap = 0;
  const Evaluation e = c.with({});
  EXPECT_FALSE(e.accepted);
  ASSERT_FALSE(e.reasons.empty());
  EXPECT_EQ(e.reasons[0], "the maps do not touch at this pose");
  EXPECT_EQ(e.inlier_ratio, 0);
  EXPECT_EQ(e.log_likelihood, 0);
}

TEST(EvaluateMatch, ObstaclesInTheOthersAirAreRejectedBothWays) {
  // One has seen the air where the other has a wall; all pairs fit.
  const auto clutter = [] { return MapWriter().box({2, 8, 2}, {3, 12, 12}, kOccupied).pruned(); };
  for (const bool air_in_a : {true, false}) {
    Case c = air_in_a ? Case{airAndWall(), clutter()} : Case{clutter(), airAndWall()};
    const Evaluation e = c.withPairs(100, 0, 0);
    EXPECT_EQ(e.free_space.conflicting, 110);
    EXPECT_EQ(e.free_space.agreeing, 0);
    EXPECT_FALSE(e.accepted);
    EXPECT_NE(reasonsOf(e).find("100.0 % of the obstacles lie in the other map's free space"),
              std::string::npos)
        << reasonsOf(e);
    c.params.max_free_conflict = 1;  // not tested
    EXPECT_TRUE(c.withPairs(100, 0, 0).accepted);
  }
}

TEST(EvaluateMatch, FreeSpaceSeesWhatTheInliersDoNot) {
  // A wrong pose lays floor on floor and the long walls on each other, and the end walls of each
  // map into the air of the other: the paper's test alone would take it.
  const auto room = [] {
    return MapWriter()
        .box({1, 1, 1}, {18, 18, 8}, kFree)
        .shell({0, 0, 0}, {19, 19, 9}, kOccupied)
        .pruned();
  };
  Case c{room(), room()};
  c.T_a_b = poseOf(1.5, 0, 0, 0);
  const Pairs pairs = pairVoxels(c.a, c.b, c.T_a_b, Options());
  const Evaluation e = c.with(pairs);
  EXPECT_GT(e.inlier_ratio, e.threshold);
  EXPECT_GT(e.free_space.conflictRatio(), c.params.max_free_conflict);
  EXPECT_FALSE(e.accepted);

  c.T_a_b = kIdentity;
  EXPECT_TRUE(c.with(pairVoxels(c.a, c.b, c.T_a_b, Options())).accepted);
}

TEST(EvaluateMatch, OfSomeVoxelsIsNearlyThatOfAll) {
  const auto room = [](int shelf) {
    return MapWriter()
        .box({1, 1, 1}, {78, 78, 28}, kFree)
        .shell({0, 0, 0}, {79, 79, 29}, kOccupied)
        .box({shelf, 10, 1}, {shelf + 3, 60, 15}, kOccupied)
        .pruned();
  };
  Case c{room(20), room(24)};
  c.T_a_b = poseOf(0.03, -0.06, 0.02, 0.2);
  const auto evaluated = [&](unsigned enough) {
    Options match;
    match.evaluation.voxels = enough;
    const Pairs pairs = pairVoxels(c.a, c.b, c.T_a_b, match);
    EvaluationParams of_some = c.params;
    of_some.voxels = enough;
    return evaluateMatch(c.a, c.b, pairs, c.T_a_b, of_some);
  };
  const Evaluation all = evaluated(0), some = evaluated(3000);
  ASSERT_EQ(all.sampled, c.b.voxels.size());
  ASSERT_GT(all.sampled, 15000);
  EXPECT_LE(some.sampled, 3000);
  EXPECT_GT(some.sampled, 2000);
  EXPECT_GT(all.free_space.conflictRatio(), 0.02);
  EXPECT_NEAR(some.overlap, all.overlap, 0.03);
  EXPECT_NEAR(some.inlier_ratio, all.inlier_ratio, 0.03);
  EXPECT_NEAR(some.mean_mahalanobis, all.mean_mahalanobis, 0.01);
  EXPECT_NEAR(some.free_space.conflictRatio(), all.free_space.conflictRatio(), 0.03);
}

TEST(StrideFor, AsksNoMoreThanEnoughAndNotMuchLess) {
  EXPECT_EQ(strideFor(100, 0), 1);
  EXPECT_EQ(strideFor(0, 10), 1);
  EXPECT_EQ(strideFor(10, 10), 1);
  EXPECT_EQ(strideFor(11, 10), 2);
  EXPECT_EQ(strideFor(30, 10), 3);
}

TEST(EvaluateMatch, AClearDifferenceOfSizeIsRejected) {
  const Case c{wall(), wall()};
  const Pairs good = {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {3, 3, 0}, {4, 4, 0}};
  const auto judged = [&](double ratio, double deviation) {
    return evaluateMatch(c.a, c.b, good, c.T_a_b, c.params, {}, {}, {ratio, deviation});
  };
  EXPECT_TRUE(judged(1, 0.001).accepted);
  EXPECT_TRUE(judged(1.015, 0.001).accepted) << "small";
  EXPECT_TRUE(judged(0.95, 0.03).accepted) << "not clear";
  for (const double ratio : {0.95, 1.05}) {
    const Evaluation e = judged(ratio, 0.002);
    EXPECT_FALSE(e.accepted);
    EXPECT_NE(
        reasonsOf(e).find("map B seems to be scaled by " + std::to_string(ratio).substr(0, 5)),
        std::string::npos)
        << reasonsOf(e);
  }
}

TEST(EvaluateMatch, AsksForTheUnitOfVoxelsOfManyMetres) {
  const auto wide = [] { return MapWriter(100).box({0, 0, 0}, {0, 9, 9}, 0.F).pruned(); };
  const Case c{wall(), wide()};
  EXPECT_NE(reasonsOf(c.withPairs(5, 0, 0))
                .find("the voxels of map B are 100 m wide: are its "
                      "lengths in millimetres?"),
            std::string::npos);
  const Case usual{wall(), wall()};
  EXPECT_EQ(reasonsOf(usual.withPairs(5, 0, 0)).find("millimetres"), std::string::npos);
}

// ---------------------------------------------------------------- how firmly a pose is held

TEST(Deviation, IsThatOfAPointInTheWorstDirection) {
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << 0.01, 0.04, 0.09, 1e-4, 4e-4, 9e-4;
  EXPECT_NEAR(deviationAt(covariance, {0, 0, 0}).translation, 0.3, 1e-12);
  EXPECT_NEAR(deviationAt(covariance, {0, 0, 0}).rotation, 0.03, 1e-12);
  // Turning about z by 0.03 rad takes what is 100 m away on x by 3 m along y.
  EXPECT_NEAR(deviationAt(covariance, {100, 0, 0}).translation, std::sqrt(0.04 + 9), 1e-9);
}

TEST(Deviation, NamesTheLeastCertainDirectionAndAxis) {
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << 0.01, 0.04, 0.09, 1e-4, 9e-4, 4e-4;
  const PoseDeviation d = deviationAt(covariance, {0, 0, 0});
  EXPECT_TRUE(d.directions.col(0).isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(d.directions.col(2).isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(d.axes.col(0).isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_EQ(d.free_directions, 0);
  EXPECT_EQ(d.free_axes, 0);
  EXPECT_EQ(textOf(d),
            "standard deviations 0.3 m along [0.00 0.00 1.00] (vertical), 1.7 deg about "
            "[0.00 1.00 0.00] (level) of map A's frame");
  EXPECT_EQ(textOf(PoseDeviation{0.3, 0.01}), "standard deviations 0.3 m, 0.57 deg");
}

TEST(Deviation, SaysAlongWhatMapBSlides) {
  const Eigen::Vector3d along(0.8, 0.6, 0);
  Matrix6d covariance = 1e-4 * Matrix6d::Identity();
  covariance.topLeftCorner<3, 3>() += kUnknownVariance * along * along.transpose();
  const PoseDeviation one = deviationAt(covariance, {5, 3, 1});
  EXPECT_EQ(one.free_directions, 1);
  EXPECT_EQ(textOf(one), "map B slides freely along [0.80 0.60 0.00] (level) of map A's frame");
  covariance(2, 2) += kUnknownVariance;
  EXPECT_EQ(textOf(deviationAt(covariance, {5, 3, 1})),
            "map B slides freely in all directions across [-0.60 0.80 0.00] (level) of map A's "
            "frame");
  EXPECT_EQ(textOf(deviationAt(kUnknownVariance * Matrix6d::Identity(), {0, 0, 0})),
            "map B slides freely in all directions and turns freely about all axes of map A's "
            "frame");
}

TEST(Deviation, AMapThatTurnsAboutOneAxisDoesNotSlide) {
  // A round room: B turns about the vertical through (4, 0, 0).
  Matrix6d about_centre = 1e-4 * Matrix6d::Identity();
  about_centre(5, 5) = kUnknownVariance;
  const Matrix6d J = stepAbout(Eigen::Vector3d::Zero(), {4, 0, 0});
  const PoseDeviation d = deviationAt(J * about_centre * J.transpose(), {9, 0, 0});
  EXPECT_GT(d.translation, 100);  // 5 m beside the axis
  EXPECT_EQ(d.free_directions, 0);
  EXPECT_EQ(d.free_axes, 1);
  EXPECT_EQ(textOf(d), "map B turns freely about [0.00 0.00 1.00] (vertical) of map A's frame");
}

TEST(Deviation, ProbabilityOfStayingIsThatOfAGaussian) {
  EXPECT_EQ(probabilityOfStaying({}), 1);
  EXPECT_NEAR(probabilityOfStaying({0.6, 0}), 0.6827, 1e-4);
  EXPECT_NEAR(probabilityOfStaying({0, 3 * M_PI / 180}), 0.9545, 1e-4);
  EXPECT_NEAR(probabilityOfStaying({0.6, 3 * M_PI / 180}), 0.6827 * 0.9545, 1e-4);
  EXPECT_LT(probabilityOfStaying({1000, 0}), 1e-3);
}

}  // namespace
}  // namespace mrpt::fusion::test::evaluation_test
