// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/poses.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/features/thinning.h"
#include "fusion_core/map/eigen_solvers.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_core/pair/match.h"
#include "fusion_core/registration/pose_covariance.h"
#include "fusion_core/verdict/evaluation.h"
#include "fusion_octree/resampling.h"
#include "robot_simulator.h"
#include "support/apartment_pair.h"
#include "support/matching_tools.h"

namespace mrpt::fusion::test::matching_test {
namespace {

class Matching : public testing::Test {
 protected:
  /** Made once, for the tests only read them. */
  static const ApartmentPair& maps() {
    static const ApartmentPair pair(0.2);
    return pair;
  }
  static const ApartmentPair& fineMaps() {
    static const ApartmentPair pair(0.1);
    return pair;
  }
  const Eigen::Isometry3d truth = maps().truth;
  const Eigen::Isometry3d guess = truth * poseOf(0.6, -0.5, 0.2, 7, 2, -2);
  const Options params{};

  /** A match that starts from the guess alone. */
  Options noStarts() const {
    Options p = params;
    p.search.hypotheses = 0;
    return p;
  }
  /** Guesses off by this: few voxels come from there to a pose 2 m and 30 degrees off, and all from
   * that one to the truth. */
  const std::vector<Eigen::Isometry3d> few_led_astray = {
      poseOf(2, 1.6, 0, -10), poseOf(2, 2, 0, 15), poseOf(2.2, 0.8, 0, -15)};
};

void expectIdentical(const MatchResult& a, const MatchResult& b) {
  EXPECT_EQ(a.T_a_b.matrix(), b.T_a_b.matrix());
  EXPECT_EQ(a.covariance, b.covariance);
  ASSERT_EQ(a.iterations.size(), b.iterations.size());
  for (size_t i = 0; i < a.iterations.size(); i++)
    EXPECT_EQ(a.iterations[i].mse, b.iterations[i].mse);
  ASSERT_EQ(a.pairs.size(), b.pairs.size());
  for (size_t i = 0; i < a.pairs.size(); i++) {
    ASSERT_EQ(a.pairs[i].a, b.pairs[i].a);
    ASSERT_EQ(a.pairs[i].b, b.pairs[i].b);
  }
  ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
  for (size_t i = 0; i < a.hypotheses.size(); i++) {
    EXPECT_EQ(a.hypotheses[i].T_a_b.matrix(), b.hypotheses[i].T_a_b.matrix());
    EXPECT_EQ(a.hypotheses[i].agreement, b.hypotheses[i].agreement);
    EXPECT_EQ(a.hypotheses[i].covariance, b.hypotheses[i].covariance);
  }
}

// ---------------------------------------------------------------- rivals of what was reached

class Rivals : public Matching {
 protected:
  /** A match that reached \a T and has one rival, of which nothing else is known. */
  static MatchResult reached(const Eigen::Isometry3d& T, double agreement,
                             const Eigen::Isometry3d& rival, double of_rival) {
    MatchResult result;
    result.T_a_b = T;
    for (const auto& [pose, value] : {std::pair(T, agreement), std::pair(rival, of_rival)})
      result.hypotheses.push_back({pose, value, kUnknownVariance * Matrix6d::Identity()});
    return result;
  }
  void registerFrom(const Eigen::Isometry3d& began, MatchResult& result) const {
    registerRivals(maps().a, maps().b, association, began, params, result);
  }

  const VoxelAssociation association = associationOf(maps().a, maps().b, params.registration);
  const Eigen::Isometry3d wrong = truth * poseOf(3, 1, 0, 25);
  const Eigen::Isometry3d near_truth = truth * poseOf(0.1, -0.1, 0, 1);
};

TEST_F(Rivals, AreRegisteredIfTheyAgreeBetterThanWhatWasReached) {
  MatchResult result = reached(wrong, 1, near_truth, 100);
  registerFrom(truth * poseOf(5, 0, 0, 0), result);
  EXPECT_LT(metresBetween(result.T_a_b, truth), 0.05);
  EXPECT_TRUE(result.hasPairs());
  EXPECT_FALSE(result.iterations.empty());
  ASSERT_EQ(result.hypotheses.size(), 2U);
  EXPECT_EQ(result.hypotheses[1].T_a_b.matrix(), wrong.matrix());
  EXPECT_LT(result.runnerUp(), 1);
}

TEST_F(Rivals, AreNotRegisteredIfTheMatchAgreesBetter) {
  MatchResult result = reached(wrong, 100, near_truth, 99);
  registerFrom(wrong, result);
  EXPECT_EQ(result.T_a_b.matrix(), wrong.matrix());
  EXPECT_TRUE(result.iterations.empty());
}

TEST_F(Rivals, FromWhichTheRegistrationBeganAreNotRegisteredAgain) {
  MatchResult result = reached(wrong, 1, near_truth, 100);
  registerFrom(near_truth, result);
  EXPECT_EQ(result.T_a_b.matrix(), wrong.matrix());
  EXPECT_TRUE(result.iterations.empty());
}

TEST_F(Rivals, ThatLeadToAPoseThatAgreesLessChangeNothingButTheIterations) {
  constexpr double kMoreThanVoxels = 1e9;
  MatchResult result = reached(near_truth, kMoreThanVoxels, wrong, 2 * kMoreThanVoxels);
  registerFrom(near_truth, result);
  EXPECT_EQ(result.T_a_b.matrix(), near_truth.matrix());
  EXPECT_FALSE(result.iterations.empty());
}

// ---------------------------------------------------------------- accuracy

TEST_F(Matching, ComesBackToTheTruthFromGuessesOffByAMetreAndTenDegrees) {
  for (const auto& off :
       {poseOf(0, 0, 0, 0), poseOf(1, 0, 0, 0), poseOf(-1, 0, 0, 0), poseOf(0, 1, 0, 0),
        poseOf(0, -1, 0, 0), poseOf(0, 0, 0, 10), poseOf(0, 0, 0, -10), poseOf(0.7, 0.7, 0, 10),
        poseOf(-0.7, 0.7, 0.1, -10), poseOf(-0.6, -0.6, -0.5, 5, 5, -5),
        poseOf(0.4, -0.8, 0.4, -7, 5, 5)}) {
    const MatchResult r = matchTwoLevel(fineMaps().a, fineMaps().b, truth * off, params);
    EXPECT_LT(metresBetween(r.T_a_b, truth), 0.1) << off.matrix();
    EXPECT_LT(degreesBetween(r.T_a_b, truth), 1) << off.matrix();
    EXPECT_TRUE(r.hasPairs());
  }
}

TEST_F(Matching, SearchFindsTheTruthWhereTheTwoLevelsAloneDoNot) {
  const Eigen::Isometry3d far = truth * poseOf(-2.4, -2.4, 0, -18);
  EXPECT_GT(metresBetween(matchTwoLevel(fineMaps().a, fineMaps().b, far, params).T_a_b, truth), 1);
  const MatchResult r = matchMaps(fineMaps().a, fineMaps().b, far, params);
  EXPECT_LT(metresBetween(r.T_a_b, truth), 0.1);
  EXPECT_LT(degreesBetween(r.T_a_b, truth), 1);
}

TEST_F(Matching, FindsThePoseWithoutAGuess) {
  Options no_guess = params;
  no_guess.search = everywhere(params.search);
  for (const auto& off : {poseOf(0, 0, 0, 0), poseOf(-15, 18, 2, 170), poseOf(9, 20, -1, -95)}) {
    const MatchResult r = matchMaps(fineMaps().a, fineMaps().b, truth * off, no_guess);
    EXPECT_LT(metresBetween(r.T_a_b, truth), 0.1) << off.matrix();
    EXPECT_LT(degreesBetween(r.T_a_b, truth), 1) << off.matrix();
  }
}

TEST_F(Matching, FindsThePoseOfMapsWithoutACommonVertical) {
  Options no_guess = params;
  no_guess.search = everywhere(params.search);
  no_guess.search.rotations = SearchRotations::All;
  // Upright, upside down, on its side, and every which way; the model lying down, too.
  for (const auto& [T_a, T_b] :
       {std::pair(kIdentity, kIdentity), std::pair(kIdentity, poseOf(2, 1, -3, 40, 0, 180)),
        std::pair(kIdentity, poseOf(0, 5, 0, -110, 12, 90)),
        std::pair(poseOf(1, 2, 3, 20, 35, -70), poseOf(-4, 0, 2, 70, -50, 25))}) {
    const auto map_a = mrpt::fusion::transformOcTree(*fineMaps().map_a, T_a, 0.1);
    const auto map_b = mrpt::fusion::transformOcTree(*fineMaps().map_b, T_b, 0.1);
    const MapFeatures a = featuresOf(*map_a, no_guess), b = featuresOf(*map_b, no_guess);
    const Eigen::Isometry3d T_a_b = T_a * truth * T_b.inverse();
    MatchResult r = matchMaps(a, b, kIdentity, no_guess);
    EXPECT_LT(metresBetween(r.T_a_b, T_a_b), 0.1) << T_b.matrix();
    EXPECT_LT(degreesBetween(r.T_a_b, T_a_b), 1) << T_b.matrix();
    EXPECT_TRUE(judgeMatch(a, b, no_guess, {}, r).accepted);
  }
}

TEST_F(Matching, GivesTheHypothesesThatItCompared) {
  const MatchResult r = matchMaps(fineMaps().a, fineMaps().b, guess, params);
  ASSERT_GE(r.hypotheses.size(), 2U);
  EXPECT_LT(metresBetween(r.hypotheses[0].T_a_b, truth), 0.1);
  for (size_t i = 1; i < r.hypotheses.size(); i++)
    EXPECT_LE(r.hypotheses[i].agreement, r.hypotheses[i - 1].agreement);
  EXPECT_TRUE(matchTwoLevel(fineMaps().a, fineMaps().b, guess, params).hypotheses.empty());
}

TEST_F(Matching, ComparesThePoseThatAllVoxelsLeadToIfFewLedElsewhere) {
  for (const auto& off : few_led_astray) {
    MatchResult r = matchMaps(fineMaps().a, fineMaps().b, truth * off, noStarts());
    EXPECT_LT(metresBetween(r.T_a_b, truth), 0.1) << off.matrix();
    ASSERT_EQ(r.hypotheses.size(), 2U) << off.matrix();
    EXPECT_EQ(r.hypotheses[0].T_a_b.matrix(), r.T_a_b.matrix());
    EXPECT_EQ(r.hypotheses[0].covariance, r.covariance);
    EXPECT_GT(metresBetween(r.hypotheses[1].T_a_b, truth), 1) << "what few came to is a rival";
    EXPECT_LT(r.runnerUp(), 0.1);
    EXPECT_TRUE(judgeMatch(fineMaps().a, fineMaps().b, noStarts(), {}, r).accepted);
  }
}

TEST_F(Matching, WithoutSearchIsThatOfTheTwoLevels) {
  Options no_search = params;
  no_search.search.translation = 0;
  expectIdentical(matchMaps(maps().a, maps().b, guess, no_search),
                  matchTwoLevel(maps().a, maps().b, guess, params));
}

TEST_F(Matching, EdgeCandidatesAreTheMostBentPieceOfEachCube) {
  const SurfaceVoxels& matched = fineMaps().a.matched;
  Options sparse = params;
  sparse.features.edge_spacing = 0.4;
  const auto cubeOf = [](const octomap::OcTreeKey& k) {
    return std::make_tuple(k[0] >> 2, k[1] >> 2, k[2] >> 2);  // of 0.1 m voxels
  };
  std::map<std::tuple<int, int, int>, float> most_bent;
  for (size_t k = 0; k < matched.voxels.size(); k++) {
    float& most = most_bent.try_emplace(cubeOf(matched.voxels.key[k]), -1.F).first->second;
    most = std::max(most, matched.surfaces.variation[k]);
  }
  const std::vector<uint32_t> candidates = edgeCandidates(matched, sparse.features);
  ASSERT_EQ(candidates.size(), most_bent.size());
  for (const uint32_t k : candidates)
    EXPECT_EQ(matched.surfaces.variation[k], most_bent.at(cubeOf(matched.voxels.key[k])));
  sparse.features.edge_spacing = 0;
  EXPECT_EQ(edgeCandidates(matched, sparse.features).size(), matched.voxels.size());
}

TEST_F(Matching, FeaturesAreOfTheThinnedVoxels) {
  const MapFeatures& f = fineMaps().a;
  const Thinned kept = thinOut(f.voxels, params.features.voxel_spacing);
  const Surfaces all = computeSurfaces(f.voxels, params.features.edges);
  ASSERT_EQ(f.matched.voxels.size(), kept.index.size());
  ASSERT_LT(kept.index.size(), f.voxels.size() / 2);
  EXPECT_EQ(f.matched.surfaces.weight, kept.weight);
  for (size_t k = 0; k < kept.index.size(); k++) {
    EXPECT_EQ(f.matched.voxels.key[k], f.voxels.key[kept.index[k]]);
    EXPECT_EQ(f.matched.voxels.centre[k], f.voxels.centre[kept.index[k]]);
    EXPECT_EQ(f.matched.voxels.probability[k], f.voxels.probability[kept.index[k]]);
    EXPECT_EQ(f.matched.surfaces.normal[k], all.normal[kept.index[k]]);
    EXPECT_EQ(f.matched.surfaces.point[k], all.point[kept.index[k]]);
  }
  Options all_voxels = params;
  all_voxels.features.voxel_spacing = 0;
  EXPECT_EQ(featuresOf(*fineMaps().map_a, all_voxels).matched.voxels.size(), f.voxels.size());
}

TEST_F(Matching, RecordsThePoseThatEachIterationReached) {
  const MatchResult r = matchTwoLevel(maps().a, maps().b, guess, params);
  ASSERT_FALSE(r.iterations.empty());
  EXPECT_EQ(r.iterations.back().T_a_b.matrix(), r.T_a_b.matrix());
}

TEST_F(Matching, AsPublishedSucceedsByThePapersOwnCriterion) {
  // Not nearer: scene voxels beyond the model's border pull at it, as far as the gate lets them.
  Options as_published = params;
  as_published.registration.voxel_metric = VoxelMetric::Point;
  as_published.registration.voxel_level.final_gate = as_published.registration.voxel_level.gate;
  const MatchResult r = matchTwoLevel(fineMaps().a, fineMaps().b, guess, as_published);
  EXPECT_LT(metresBetween(r.T_a_b, truth), 0.6);
  EXPECT_LT(degreesBetween(r.T_a_b, truth), 6);
}

TEST_F(Matching, TheMatchIsAcceptedAndAPoseOffByAMetreIsNot) {
  const auto verdictAt = [](const Eigen::Isometry3d& T, const Pairs& pairs) {
    return evaluateMatch(fineMaps().a, fineMaps().b, pairs, T, EvaluationParams());
  };
  const MatchResult r = matchTwoLevel(fineMaps().a, fineMaps().b, guess, params);
  EXPECT_TRUE(verdictAt(r.T_a_b, r.pairs).accepted);
  const Eigen::Isometry3d wrong = truth * poseOf(1, 0, 0, 0);
  EXPECT_FALSE(verdictAt(wrong, pairVoxels(fineMaps().a, fineMaps().b, wrong, params)).accepted);
}

TEST_F(Matching, EdgesWidenTheBasinOfConvergence) {
  Options voxels_only = params;
  voxels_only.registration.edge_level.max_iterations = 0;
  constexpr int kStarts = 24;
  int with_edges = 0, without = 0;
  for (int i = 0; i < kStarts; i++) {
    const double direction = i * 2 * M_PI / kStarts;
    const Eigen::Isometry3d far =
        truth * poseOf(1.2 * std::cos(direction), 1.2 * std::sin(direction), 0.1, i % 2 ? 10 : -10);
    const auto succeeds = [&](const Options& p) {
      const auto reached = matchTwoLevel(fineMaps().a, fineMaps().b, far, p).T_a_b;
      return metresBetween(reached, truth) < 0.1;
    };
    with_edges += succeeds(params);
    without += succeeds(voxels_only);
  }
  EXPECT_GE(with_edges, kStarts * 9 / 10);
  EXPECT_LT(without, kStarts * 2 / 3);
}

TEST_F(Matching, OfAMapWithItselfStaysAtTheIdentity) {
  const MatchResult r = matchTwoLevel(maps().a, maps().a, Eigen::Isometry3d::Identity(), params);
  EXPECT_LT(metresBetween(r.T_a_b, Eigen::Isometry3d::Identity()), 1e-9);
  EXPECT_LT(degreesBetween(r.T_a_b, Eigen::Isometry3d::Identity()), 1e-9);
  EXPECT_EQ(r.pairs.size(), maps().a.voxels.size());
  EXPECT_EQ(meanSquaredError(r.pairs), 0);
}

/** Whole voxels and a quarter turn: takes a grid onto itself. */
Eigen::Isometry3d gridMotion(double x, double y, double z) {
  Eigen::Isometry3d M = Eigen::Isometry3d::Identity();
  M.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  M.translation() << x, y, z;
  return M;
}

/** A map seen from another frame, with its features. */
struct MovedMap {
  MovedMap(const octomap::OcTree& source, const Eigen::Isometry3d& M)
      : map(mrpt::fusion::transformOcTree(source, M, source.getResolution())),
        features(allFeaturesOf(*map)) {}

  std::unique_ptr<octomap::OcTree> map;
  MapFeatures features;
};

/** Eq. (22), iterated until nothing changes: two runs end in the same place if they can. */
Options toTheEnd() {
  Options params;
  params.registration.voxel_metric = VoxelMetric::Point;
  params.registration.min_step_translation = params.registration.min_step_rotation = 0;
  params.registration.voxel_level.max_iterations = 60;
  return params;
}

TEST_F(Matching, MovesWithTheModel) {
  const Eigen::Isometry3d M = gridMotion(12.6, -4.2, 0.8);
  const MovedMap a(*maps().map_a, M);
  ASSERT_EQ(a.features.voxels.size(), maps().a.voxels.size());
  const auto difference = [&](const Options& p) {
    const MatchResult here = matchTwoLevel(maps().a, maps().b, guess, p);
    const MatchResult there = matchTwoLevel(a.features, maps().b, M * guess, p);
    return std::pair(metresBetween(M.inverse() * there.T_a_b, here.T_a_b),
                     degreesBetween(M.inverse() * there.T_a_b, here.T_a_b));
  };
  const auto [metres, degrees] = difference(toTheEnd());
  EXPECT_LT(metres, 1e-6);
  EXPECT_LT(degrees, 1e-5);
  // Where iterations stop is another matter, but no large one.
  EXPECT_LT(difference(params).first, 2e-3);
  EXPECT_LT(difference(params).second, 0.02);
}

TEST_F(Matching, MovesWithTheScene) {
  const Eigen::Isometry3d M = gridMotion(-7.2, 3.4, -1.4);
  const MovedMap b(*maps().map_b, M);
  ASSERT_EQ(b.features.voxels.size(), maps().b.voxels.size());
  const MatchResult here = matchTwoLevel(maps().a, maps().b, guess, toTheEnd());
  const MatchResult there = matchTwoLevel(maps().a, b.features, guess * M.inverse(), toTheEnd());
  EXPECT_LT(metresBetween(there.T_a_b * M, here.T_a_b), 1e-6);
  EXPECT_LT(degreesBetween(there.T_a_b * M, here.T_a_b), 1e-5);
}

TEST_F(Matching, WorksFarFromTheOrigin) {
  // Georeferenced: an octree of 0.1 m reaches out to 3.2 km.
  const Eigen::Isometry3d M = gridMotion(1500, -2000, 100);
  const MovedMap a(*fineMaps().map_a, M);
  const MatchResult r = matchTwoLevel(a.features, fineMaps().b, M * guess, params);
  EXPECT_LT(metresBetween(r.T_a_b, M * truth), 0.1);
  EXPECT_LT(degreesBetween(r.T_a_b, M * truth), 1);
}

// ---------------------------------------------------------------- what it reports

TEST_F(Matching, RecordsItsIterationsInOrder) {
  std::vector<IterationRecord> told;
  const MatchResult r = matchTwoLevel(maps().a, maps().b, guess, params,
                                      [&](const IterationRecord& i) { told.push_back(i); });
  ASSERT_EQ(told.size(), r.iterations.size());
  size_t at_edges = 0;
  for (size_t i = 0; i < told.size(); i++) {
    const IterationRecord& record = r.iterations[i];
    EXPECT_EQ(told[i].mse, record.mse);
    at_edges += record.level == Level::Edge;
    EXPECT_LE(r.iterations[i > 0 ? i - 1 : 0].level, record.level);
    EXPECT_GE(record.pairs, MatchResult::kMinPairs);
    EXPECT_GT(record.mse, 0);
    EXPECT_GE(record.step_translation, 0);
    EXPECT_GE(record.step_rotation, 0);
  }
  EXPECT_GE(at_edges, 2);
  EXPECT_LE(at_edges, params.registration.edge_level.max_iterations);
  EXPECT_GE(told.size() - at_edges, 1);
  EXPECT_LE(told.size() - at_edges, params.registration.voxel_level.max_iterations);
  // The pairs come closer at each level, and it ends because it stands still.
  EXPECT_LT(r.iterations[at_edges - 1].mse, r.iterations.front().mse);
  EXPECT_LE(r.iterations.back().mse, r.iterations[at_edges].mse);
  EXPECT_LT(r.iterations.back().step_translation, params.registration.min_step_translation);
  EXPECT_LT(r.iterations.back().step_rotation, params.registration.min_step_rotation);
}

TEST_F(Matching, RecordsTheMseAndTheStepOfAnIteration) {
  Options one_iteration = params;
  one_iteration.registration.edge_level.max_iterations = 0;
  one_iteration.registration.voxel_level.max_iterations = 1;
  const Eigen::Isometry3d near = truth * poseOf(0.1, 0.05, 0, 1);
  const MatchResult r = matchTwoLevel(maps().a, maps().b, near, one_iteration);
  ASSERT_EQ(r.iterations.size(), 1);
  EXPECT_EQ(r.iterations[0].level, Level::Voxel);
  const Pairs pairs = pairVoxels(maps().a, maps().b, near, params);
  EXPECT_EQ(r.iterations[0].pairs, pairs.size());
  EXPECT_DOUBLE_EQ(r.iterations[0].mse, meanSquaredError(pairs));
  const Eigen::Vector3d middle = meanOf(maps().b.matched.voxels.centre);
  EXPECT_NEAR(r.iterations[0].step_translation, (r.T_a_b * middle - near * middle).norm(), 1e-9);
  EXPECT_NEAR(r.iterations[0].step_rotation, degreesBetween(r.T_a_b, near) * kDegree, 1e-9);
}

TEST_F(Matching, PairsAreThoseAtItsPose) {
  const MatchResult r = matchTwoLevel(maps().a, maps().b, guess, params);
  ASSERT_GT(r.pairs.size(), 1000);
  for (const Pair& p : r.pairs) {
    const Eigen::Vector3d e = maps().a.voxels.centre[p.a].cast<double>() -
                              r.T_a_b * maps().b.voxels.centre[p.b].cast<double>();
    ASSERT_NEAR(p.squared_distance, e.squaredNorm(), 1e-4);
    ASSERT_LT(e.norm(), params.registration.voxel_level.gate);
  }
}

TEST_F(Matching, CovarianceIsPositiveDefinite) {
  const MatchResult r = matchTwoLevel(maps().a, maps().b, guess, params);
  const SymmetricEigen<6> solution(r.covariance);
  EXPECT_GT(solution.eigenvalues[0], 0);
  EXPECT_LT(solution.eigenvalues[5], 0.1);  // thousands of pairs
}

// ---------------------------------------------------------------- nothing to go by

/** A piece of a corridor along x, 2.5 m wide and high, with walls as rough as a robot maps them;
 * pillars stand in it or not. In a frame of its own. */
std::unique_ptr<octomap::OcTree> corridor(int x0, int x1, bool with_pillars, unsigned seed,
                                          const Eigen::Isometry3d& T) {
  std::mt19937 generator(seed);
  std::uniform_int_distribution<int> tenth(0, 19);
  MapWriter map(0.1);
  map.box({x0, 0, 0}, {x1, 24, 24}, kFree);
  const auto wall = [&](const Cell& low, const Cell& high, int across) {
    for (int x = low[0]; x <= high[0]; x++)
      for (int y = low[1]; y <= high[1]; y++)
        for (int z = low[2]; z <= high[2]; z++) {
          Cell c{x, y, z};
          const int rough = tenth(generator);
          c[across] += rough == 0 ? 1 : rough == 1 ? -1 : 0;
          map.voxel(c, kOccupied);
        }
  };
  for (const int at : {0, 24}) {
    wall({x0, at, 0}, {x1, at, 24}, 1);
    wall({x0, 0, at}, {x1, 24, at}, 2);
  }
  if (with_pillars)
    for (const int x : {37, 88, 131}) map.box({x, 1, 1}, {x + 3, 4, 23}, kOccupied);
  return mrpt::fusion::transformOcTree(*map.pruned(), T, 0.1);
}

TEST_F(Matching, ACorridorThatSlidesIsKnownToAndIsNotTrusted) {
  for (const double yaw : {0.0, 31.0})
    for (const bool with_pillars : {false, true}) {
      const Eigen::Isometry3d T_a = poseOf(0.03, 0.02, 0.01, yaw);
      const Eigen::Isometry3d T_b = poseOf(0.04, -0.03, 0.02, yaw + 3);
      const auto a = corridor(0, 140, with_pillars, 1, T_a);
      const auto b = corridor(30, 170, with_pillars, 2, T_b);
      Options near = params;  // so near that no other pose is compared
      near.search.translation = 0.3;
      const MapFeatures fa = featuresOf(*a, near), fb = featuresOf(*b, near);
      const Eigen::Isometry3d T_a_b = T_a * T_b.inverse();
      const Eigen::Vector3d middle = T_a_b * meanOf(fb.voxels.centre);

      MatchResult r = matchMaps(fa, fb, T_a_b, near);
      const PoseDeviation deviation = deviationAt(r.covariance, middle);
      const Evaluation e = judgeMatch(fa, fb, near, {}, r);
      MatchResult given;
      given.T_a_b = T_a_b;
      given.pairs = pairVoxels(fa, fb, T_a_b, near);
      const Evaluation of_given = judgeMatch(fa, fb, near, {}, given);
      EXPECT_EQ(e.accepted, with_pillars) << yaw;
      EXPECT_EQ(of_given.accepted, with_pillars) << yaw;
      if (with_pillars) {
        EXPECT_LT(deviation.translation, 0.05);
        EXPECT_LT(of_given.deviation.translation, 0.05);
        EXPECT_LT(metresBetween(r.T_a_b, T_a_b), 0.1);
        continue;
      }
      EXPECT_GT(deviation.translation, 10);
      EXPECT_GT(of_given.deviation.translation, 10);
      const Eigen::Vector3d along = T_a.linear() * Eigen::Vector3d::UnitX();
      for (const PoseDeviation& d : {e.deviation, of_given.deviation})
        EXPECT_GT(std::abs(d.directions.col(0).dot(along)), 0.999) << d.directions.col(0);
      EXPECT_EQ(e.deviation.free_directions, 1);
      EXPECT_EQ(e.deviation.free_axes, 0);
      const bool says = std::any_of(e.reasons.begin(), e.reasons.end(), [](const auto& reason) {
        return reason.find("map B slides freely along [") != std::string::npos;
      });
      EXPECT_TRUE(says);
      Eigen::Matrix<double, 3, 6> J;  // of the middle of map B
      J << Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero();
      for (int axis = 0; axis < 3; axis++)
        J.block<3, 1>(0, 3 + axis) = Eigen::Vector3d::Unit(axis).cross(middle);
      const Eigen::Matrix3d C =
          T_a.linear().transpose() * J * r.covariance * J.transpose() * T_a.linear();
      EXPECT_GT(C(0, 0), 100) << "along the corridor";
      EXPECT_LT(C(1, 1), 1e-3 * C(0, 0)) << "across it";
      EXPECT_LT(C(2, 2), 1e-3 * C(0, 0)) << "its height";
    }
}

TEST_F(Matching, WithoutPairsReturnsTheGuess) {
  const Eigen::Isometry3d far = truth * poseOf(60, 0, 0, 33);
  const MatchResult r = matchMaps(maps().a, maps().b, far, params);
  EXPECT_EQ(r.T_a_b.matrix(), far.matrix());
  EXPECT_TRUE(r.pairs.empty());
  EXPECT_FALSE(r.hasPairs());
  EXPECT_TRUE(r.iterations.empty());
}

TEST_F(Matching, WithoutPairsClaimsNoCertainty) {
  // A guess that nothing confirms must not look like a perfect measurement.
  const MatchResult r = matchMaps(maps().a, maps().b, truth * poseOf(60, 0, 0, 33), params);
  EXPECT_GT(SymmetricEigen<6>(r.covariance).eigenvalues[0], 1);
}

TEST_F(Matching, OfEmptyMapsReturnsTheGuess) {
  const octomap::OcTree no_map(0.1);
  const MapFeatures empty = featuresOf(no_map, params);
  for (const auto& [a, b] : {std::pair{&empty, &empty}, {&maps().a, &empty}, {&empty, &maps().b}}) {
    const MatchResult r = matchMaps(*a, *b, guess, params);
    EXPECT_EQ(r.T_a_b.matrix(), guess.matrix());
    EXPECT_FALSE(r.hasPairs());
    EXPECT_TRUE(pairVoxels(*a, *b, guess, params).empty());
  }
}

TEST_F(Matching, WithoutEdgesGoesByVoxels) {
  MapFeatures a = maps().a, b = maps().b;
  a.edges = b.edges = EdgeVoxels();
  const MatchResult r = matchTwoLevel(a, b, truth * poseOf(0.1, 0.1, 0, 1), params);
  EXPECT_LT(metresBetween(r.T_a_b, truth), 0.1);
  for (const auto& record : r.iterations) EXPECT_EQ(record.level, Level::Voxel);
}

TEST_F(Matching, IsTheSameForAnyNumberOfThreads) {
  const auto match = [&] {
    return matchMaps(featuresOf(*maps().map_a, params), featuresOf(*maps().map_b, params), guess,
                     params);
  };
  expectIdentical(withThreads(1, match), withThreads(2, match));
  const auto matchFromAstray = [&] {
    return matchMaps(fineMaps().a, fineMaps().b, truth * few_led_astray[0], noStarts());
  };
  expectIdentical(withThreads(1, matchFromAstray), withThreads(2, matchFromAstray));
}

// ---------------------------------------------------------------- as robots map

/** What the simulated robot's map of the apartment is. */
std::unique_ptr<octomap::OcTree> mapOf(const sim::Recording& recording) {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  for (const auto& scan : recording.scans) {
    const auto sensor = scan.estimatedPose.mean + recording.sensorPose;
    octomap::Pointcloud points;
    for (const auto& p : scan.points) {
      const auto at = sensor.composePoint(mrpt::math::TPoint3D(p));
      points.push_back(static_cast<float>(at.x), static_cast<float>(at.y),
                       static_cast<float>(at.z));
    }
    const octomap::point3d origin(static_cast<float>(sensor.x()), static_cast<float>(sensor.y()),
                                  static_cast<float>(sensor.z()));
    tree->insertPointCloud(points, origin);
  }
  tree->prune();
  return tree;
}

TEST(MatchingOfRobotMaps, ComesBackToTheTruth) {
  const sim::VoxelGrid world(*apartment());
  sim::Lidar lidar;
  lidar.columns = 240;
  sim::RobotPlan plan_a, plan_b;
  plan_a.name = "a";
  plan_a.sensorPose = plan_b.sensorPose = mrpt::poses::CPose3D(0, 0, 1, 0, 0.03, 0);
  plan_a.floorZ = plan_b.floorZ = 0.1;
  plan_a.scanSpacing = plan_b.scanSpacing = 1;
  plan_a.waypoints = {{1.5, 3.3}, {4.7, 3.3}, {6.5, 3.3}};
  plan_a.T_w_map = mrpt::poses::CPose3D(1.5, 3.3, 0.03, 0, 0, 0);
  plan_b.name = "b";
  plan_b.waypoints = {{8.8, 2.5}, {8.8, 3.6}, {6.2, 3.3}, {4.6, 3.3}};
  plan_b.T_w_map = mrpt::poses::CPose3D(8.8, 2.5, 0.07, 37 * kDegree, 0, 0);
  const auto a = sim::simulateRobot(world, lidar, sim::PoseNoise(), plan_a, 1);
  const auto b = sim::simulateRobot(world, lidar, sim::PoseNoise(), plan_b, 2);
  const Eigen::Isometry3d truth = toEigen(sim::relativePoseTruth(a, b));

  const auto map_a = mapOf(a), map_b = mapOf(b);
  const Options params{};
  const MapFeatures features_a = featuresOf(*map_a, params);
  const MapFeatures features_b = featuresOf(*map_b, params);
  for (const auto& off : {poseOf(0.4, -0.3, 0.1, 5), poseOf(-0.5, 0.2, -0.1, -6, 2, 1)}) {
    const MatchResult r = matchTwoLevel(features_a, features_b, truth * off, params);
    EXPECT_LT(metresBetween(r.T_a_b, truth), 0.1);
    EXPECT_LT(degreesBetween(r.T_a_b, truth), 1);
    EXPECT_TRUE(
        evaluateMatch(features_a, features_b, r.pairs, r.T_a_b, EvaluationParams()).accepted);
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::matching_test
