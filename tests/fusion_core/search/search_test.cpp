// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_core/search/all_rotations.h"
#include "fusion_core/search/pose_search.h"
#include "support/matching_tools.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::search_test {
namespace {

/** The apartment as model, and a part of it as scene, in the same frame: the truth is identity. */
class Search : public testing::Test {
 protected:
  static const octomap::OcTree& model() {
    static const auto map = apartment();
    return *map;
  }
  static const OccupiedVoxels& scene() {
    static const OccupiedVoxels voxels =
        extractOccupiedVoxels(*apartment({30, 0, 0}, {99, 69, 25}));
    return voxels;
  }
  std::vector<Hypothesis> search(const octomap::OcTree& map, const OccupiedVoxels& of_scene,
                                 const Eigen::Isometry3d& guess, const SearchParams& p) const {
    const MapVoxels all(borrowed(map));
    return searchAround(all, computeSurfaces(all.voxels, {}),
                        {of_scene, computeSurfaces(of_scene, {})}, guess, p);
  }
  /** Turned about the middle of the scene, as the search turns it. */
  static Eigen::Isometry3d offBy(double x, double y, double yaw) {
    const Eigen::Vector3d middle(6.5, 3.5, 1.3);
    return Eigen::Translation3d(middle) * poseOf(x, y, 0, yaw) * Eigen::Translation3d(-middle) *
           kIdentity;
  }
  const SearchParams params{};
};

TEST_F(Search, BestHypothesisIsWithinACellOfTheTruth) {
  for (const auto& guess : {offBy(0, 0, 0), offBy(2, -1.5, 12), offBy(-1.2, 2.2, -18)}) {
    const auto found = search(model(), scene(), guess, params);
    ASSERT_FALSE(found.empty());
    const Eigen::Vector3d middle(6.5, 3.5, 1.3);
    EXPECT_LT((found[0].T_a_b * middle - middle).norm(), 1.5 * params.cell);
    EXPECT_LT(degreesBetween(found[0].T_a_b, kIdentity), 5);
  }
}

TEST_F(Search, FromEverywhereFindsTheTruthFromAnyGuess) {
  const Eigen::Vector3d middle(6.5, 3.5, 1.3);
  for (const auto& guess : {offBy(0, 0, 0), offBy(19, -17, 180), poseOf(-60, 40, 5, 77)}) {
    const auto found = search(model(), scene(), guess, everywhere(params));
    ASSERT_GE(found.size(), 2U);
    EXPECT_LT((found[0].T_a_b * middle - middle).norm(), 1.5 * params.cell) << guess.matrix();
    EXPECT_LT(degreesBetween(found[0].T_a_b, kIdentity), 5) << guess.matrix();
  }
}

TEST_F(Search, FromEverywhereIsNotLedAwayByStrayReturns) {
  octomap::OcTree stray(model());
  for (const float far : {-3000.F, 3000.F}) stray.updateNode(far, far, far, true);
  const auto found = search(stray, scene(), offBy(19, -17, 180), everywhere(params));
  ASSERT_FALSE(found.empty());
  const Eigen::Vector3d middle(6.5, 3.5, 1.3);
  EXPECT_LT((found[0].T_a_b * middle - middle).norm(), 1.5 * params.cell);
  EXPECT_LT(degreesBetween(found[0].T_a_b, kIdentity), 5);
}

TEST_F(Search, GivesSoManyDistinctHypothesesBestFirst) {
  SearchParams five = params;
  five.hypotheses = 5;
  const auto found = search(model(), scene(), offBy(1, 1, 5), five);
  ASSERT_EQ(found.size(), 5);
  for (size_t i = 1; i < found.size(); i++) {
    EXPECT_GE(found[i - 1].score, found[i].score);
    for (size_t j = 0; j < i; j++)
      EXPECT_TRUE(metresBetween(found[i].T_a_b, found[j].T_a_b) > params.cell ||
                  degreesBetween(found[i].T_a_b, found[j].T_a_b) > 1);
  }
}

TEST_F(Search, SeenFreeSpaceCountsAgainstAPose) {
  // A wall, and two places for it: one in unknown space, one in air. Both have an obstacle for half
  // of it.
  const auto wallAt = [](int x, int z_high) {
    return [=](MapWriter& map) { map.box({x, 0, 0}, {x, 29, z_high}, kOccupied); };
  };
  MapWriter map;
  map.box({20, 0, 0}, {35, 29, 29}, kFree);  // air around the second place
  wallAt(0, 14)(map);
  wallAt(27, 14)(map);
  const auto with_air = map.pruned();
  MapWriter scene_map;
  wallAt(13, 29)(scene_map);
  const OccupiedVoxels wall = extractOccupiedVoxels(*scene_map.pruned());
  SearchParams no_turns = params;
  no_turns.yaw = 0;
  no_turns.height = 0;
  const auto found = search(*with_air, wall, kIdentity, no_turns);
  ASSERT_FALSE(found.empty());
  EXPECT_NEAR(found[0].T_a_b.translation().x(), -1.3, 0.3);
}

TEST_F(Search, WithNothingToSearchGivesNone) {
  SearchParams off = params;
  off.translation = 0;
  EXPECT_TRUE(search(model(), scene(), kIdentity, off).empty());
  off = params;
  off.hypotheses = 0;
  EXPECT_TRUE(search(model(), scene(), kIdentity, off).empty());
  EXPECT_TRUE(search(octomap::OcTree(0.1), scene(), kIdentity, params).empty());
  EXPECT_TRUE(search(model(), OccupiedVoxels(), kIdentity, params).empty());
}

TEST_F(Search, IsTheSameForAnyNumberOfThreads) {
  const auto search_it = [&] { return search(model(), scene(), offBy(1, 1, 5), params); };
  const auto one = withThreads(1, search_it), two = withThreads(2, search_it);
  ASSERT_EQ(one.size(), two.size());
  for (size_t i = 0; i < one.size(); i++) {
    EXPECT_EQ(one[i].T_a_b.matrix(), two[i].T_a_b.matrix());
    EXPECT_EQ(one[i].score, two[i].score);
  }
}

TEST_F(Search, TwoFarApartPiecesOfAMapDoNotTakeTheMemoryOfAllBetween) {
  // A stray return 3 km off: a dense grid of 0.3 m over it all would be terabytes.
  octomap::OcTree stray(model());
  for (const float far : {-3000.F, 3000.F}) stray.updateNode(far, far, far, true);
  const auto found = search(stray, scene(), offBy(1, 1, 5), params);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(degreesBetween(found[0].T_a_b, kIdentity), 5);
}

}  // namespace
}  // namespace mrpt::fusion::test::search_test
