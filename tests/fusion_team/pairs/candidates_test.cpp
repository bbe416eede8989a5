// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the choice of the pairs that are matched. */
#include "fusion_team/pairs/candidates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "fusion_core/pair/align_from.h"
#include "fusion_octree/resampling.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::candidates_test {
namespace {

/** A room of 4 x 3 x 2.5 m with boxes that \a place draws. */
std::unique_ptr<octomap::OcTree> room(unsigned place) {
  std::mt19937 random(place);
  const auto draw = [&](int low, int high) {
    return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
  };
  MapWriter map(0.1);
  map.box({1, 1, 1}, {39, 29, 24}, kFree).shell({0, 0, 0}, {40, 30, 25}, kOccupied);
  for (int i = 0; i < 6; i++) {
    const Cell low{draw(1, 30), draw(1, 22), 1};
    map.box(low, {low[0] + draw(2, 9), low[1] + draw(2, 7), draw(3, 22)}, kOccupied);
  }
  return map.pruned();
}

/** Two maps of each of 15 rooms: map 2 k and map 2 k + 1 are of one room, in different frames. */
std::vector<RobotMap> mapsOf15Rooms() {
  std::vector<RobotMap> maps;
  for (unsigned place = 0; place < 15; place++) {
    const auto map = room(place);
    const auto moved = transformOcTree(*map, poseOf(3, -1, 0.3, 20.0 + 23 * place), 0.1);
    maps.push_back({"a" + std::to_string(place), PreparedMap(*map)});
    maps.push_back({"b" + std::to_string(place), PreparedMap(*moved)});
  }
  return maps;
}

std::vector<CandidatePair> chosenOf(const std::vector<RobotMap>& maps) {
  ThreadExecutor executor;
  PairMemory memory;
  return candidatePairs(maps, Options(), executor, memory);
}

bool contains(const std::vector<CandidatePair>& pairs, size_t a, size_t b) {
  return std::find(pairs.begin(), pairs.end(), CandidatePair{a, b}) != pairs.end();
}

TEST(Candidates, OfAtMost25MapsAreAllPairs) {
  const auto maps = mapsOf15Rooms();
  EXPECT_EQ(chosenOf({maps.begin(), maps.begin() + 25}).size(), 25U * 24 / 2);
}

TEST(Candidates, OfManyMapsAre11PerMapWithTheMapsOfTheSamePlace) {
  const auto maps = mapsOf15Rooms();
  const auto pairs = chosenOf(maps);
  EXPECT_EQ(pairs.size(), (kMatchesPerMap - kLaterMatchesPerMap) * maps.size());
  for (size_t b = 0; b < maps.size(); b++) {
    EXPECT_TRUE(b == 0 || contains(pairs, 0, b)) << b;
    EXPECT_TRUE(b % 2 == 0 || contains(pairs, b - 1, b)) << b;
  }
}

TEST(Candidates, DoNotDependOnTheNumberOfThreads) {
  const auto maps = mapsOf15Rooms();
  const auto pairs = chosenOf(maps);
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(chosenOf(maps), pairs);
}

TEST(Candidates, MapsWhosePosesAreFarApartAreNotMatched) {
  auto maps = mapsOf15Rooms();
  for (size_t k = 0; k < maps.size(); k++) {
    maps[k].pose = mrpt::poses::CPose3DPDFGaussian();
    maps[k].pose.mean.x(k % 2 == 0 ? 0 : 1000);
    maps[k].pose.cov.setDiagonal(6, 0.01);
  }
  for (const auto& [a, b] : chosenOf(maps)) EXPECT_TRUE(a == 0 || a % 2 == b % 2) << a << " " << b;
}

TEST(CoarseAgreement, IsLargestWithAMapOfTheSamePlace) {
  const auto map = room(1);
  const PreparedMap a(*map), turned(*transformOcTree(*map, poseOf(3, -1, 0.3, 70), 0.1)),
      other(*room(2));
  const auto agreementWith = [&](const PreparedMap& b) {
    return coarseAgreement(a, b, Prior::none(), Options());
  };
  EXPECT_GT(agreementWith(a), 0);
  EXPECT_GT(agreementWith(turned), 1.5 * agreementWith(other));
  EXPECT_NEAR(agreementWith(turned), agreementWith(a), 0.3 * agreementWith(a));
}

}  // namespace
}  // namespace mrpt::fusion::test::candidates_test
