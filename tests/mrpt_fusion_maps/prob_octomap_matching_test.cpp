// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the points of CProbOctoMap and their matching. */

#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CPointsMapXYZI.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <thread>

#include "support/mrpt_tools.h"
#include "support/observations.h"

using namespace map_tests;
using mrpt::maps::CMultiMetricMap;
using mrpt::maps::COctoMap;
using mrpt::maps::CPointsMap;
using mrpt::maps::CProbOctoMap;
using mrpt::maps::CSimplePointsMap;
using mrpt::maps::TMatchingExtraResults;
using mrpt::maps::TMatchingParams;
using mrpt::maps::TMatchingRatioParams;
using mrpt::math::TPoint3D;
using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;
using mrpt::tfest::TMatchingPairList;

namespace {

constexpr double kResolution = 0.1;

/** Returns the centres of the occupied voxels of a tree. */
std::vector<TPoint3D> centresOf(const octomap::OcTree& tree) {
  std::vector<TPoint3D> centres;
  for (const auto& [v, log_odds] : voxelsOf(tree))
    if (log_odds >= tree.getOccupancyThresLog())
      centres.emplace_back((v[0] + 0.5) * tree.getResolution(), (v[1] + 0.5) * tree.getResolution(),
                           (v[2] + 0.5) * tree.getResolution());
  return centres;
}

std::vector<TPoint3D> pointsOf(const CPointsMap& map) {
  std::vector<TPoint3D> points(map.size());
  for (size_t i = 0; i < map.size(); i++) {
    float x, y, z;
    map.getPointFast(i, x, y, z);
    points[i] = TPoint3D(x, y, z);
  }
  return points;
}

/** Sorts points in single precision. */
std::vector<std::array<long, 3>> sorted(const std::vector<TPoint3D>& points) {
  std::vector<std::array<long, 3>> micrometres;
  for (const auto& p : points)
    micrometres.push_back({std::lround(1e5 * p.x), std::lround(1e5 * p.y), std::lround(1e5 * p.z)});
  std::sort(micrometres.begin(), micrometres.end());
  return micrometres;
}

/** Returns some points near the obstacles of a map and some points far away. */
CSimplePointsMap otherPoints(unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> place(-2.5F, 2.5F);
  CSimplePointsMap points;
  for (int i = 0; i < 1500; i++) points.insertPoint(place(rng), place(rng), place(rng) / 2);
  return points;
}

/** Matches by brute force. Counts the points of the other map that have a point of this map within
 * a distance, in space or in the plane, and adds up their square distances. */
struct Matches {
  size_t count = 0;
  double sum = 0;
};
Matches bruteForce(const std::vector<TPoint3D>& ours, const std::vector<TPoint3D>& theirs,
                   const CPose3D& pose, double reach, bool plane) {
  Matches m;
  for (const auto& p : theirs) {
    const auto q = pose.composePoint(p);
    double best = 1e9;
    for (const auto& c : ours) {
      const double dz = plane ? 0 : c.z - q.z;
      best = std::min(best, std::hypot(std::hypot(c.x - q.x, c.y - q.y), dz));
    }
    if (best > reach) continue;
    m.count++;
    m.sum += best * best;
  }
  return m;
}

const CPose3D kPose(0.21, -0.13, 0.08, 0.3, 0.02, -0.01);

}  // namespace

// ---------------------------------------------------------------- the points of a map

TEST(ProbOctoMapPoints, AreTheCentresOfOccupiedVoxels) {
  CProbOctoMap map(sceneTree(kResolution, 21));
  for (const double threshold : {0.5, 0.9}) {
    map.octree().setOccupancyThres(threshold);
    const auto expected = centresOf(map.octree());
    ASSERT_GT(expected.size(), 500U);
    const auto* points = map.getAsSimplePointsMap();
    ASSERT_TRUE(points);
    EXPECT_EQ(sorted(expected), sorted(pointsOf(*points)));
  }
  EXPECT_TRUE(CProbOctoMap(0.1).getAsSimplePointsMap()->empty());
}

TEST(ProbOctoMapPoints, AreTheSameObjectUntilTheMapChanges) {
  CProbOctoMap map(sceneTree(kResolution, 22));
  const auto* points = map.getAsSimplePointsMap();
  EXPECT_EQ(points, map.getAsSimplePointsMap());
  const size_t before = points->size();
  octomap::OcTree& held = map.octree();
  map.getAsSimplePointsMap();
  held.updateNode(9.05, 9.05, 9.05, true);  // the map does not notice this
  EXPECT_EQ(before + 1, map.getAsSimplePointsMap()->size());
  map.clear();
  EXPECT_TRUE(map.getAsSimplePointsMap()->empty());
}

TEST(ProbOctoMapPoints, OfACopyAreItsOwn) {
  CProbOctoMap map(sceneTree(kResolution, 23));
  const auto* points = map.getAsSimplePointsMap();
  const size_t size = points->size();
  CProbOctoMap copy(map);
  EXPECT_NE(points, copy.getAsSimplePointsMap());
  copy.clear();
  EXPECT_TRUE(copy.getAsSimplePointsMap()->empty());
  EXPECT_EQ(size, points->size());
  copy = map;
  EXPECT_EQ(size, copy.getAsSimplePointsMap()->size());
}

TEST(ProbOctoMapPoints, ComeBackAfterAParticleFilterHasCleanedUp) {
  CProbOctoMap map(sceneTree(kResolution, 24));
  const auto before = pointsOf(*map.getAsSimplePointsMap());
  map.auxParticleFilterCleanUp();
  EXPECT_EQ(before, pointsOf(*map.getAsSimplePointsMap()));
}

TEST(ProbOctoMapPoints, ALeafThatIsTooLargeToExpandThrows) {
  auto tree = std::make_unique<octomap::OcTree>(kResolution);
  putLeaf(*tree, {0, 0, 0}, 1, 2.0F);
  const CProbOctoMap map(std::move(tree));
  const MemoryLimit limit(500);
  EXPECT_THROW(map.getAsSimplePointsMap(), std::length_error);
  EXPECT_NEAR(0.05 * 0.05, map.squareDistanceToClosestCorrespondence(0, 0.05F), 1e-6);
}

// ---------------------------------------------------------------- matching

TEST(ProbOctoMapMatching, FindsThePairsThatBruteForceFinds) {
  const CProbOctoMap map(sceneTree(kResolution, 25));
  const CSimplePointsMap other = otherPoints(1);
  const auto ours = centresOf(map.octree()), theirs = pointsOf(other);
  const CPose2D pose_2d(kPose);
  for (const float reach : {0.15F, 0.4F}) {
    TMatchingParams params;
    params.maxDistForCorrespondence = reach;
    // 2-D and 3-D matchings alternate on one map. The k-d trees of MRPT cannot do this.
    for (const bool plane : {true, false, true}) {
      TMatchingPairList pairs;
      TMatchingExtraResults extra;
      if (plane)
        map.determineMatching2D(&other, pose_2d, pairs, params, extra);
      else
        map.determineMatching3D(&other, kPose, pairs, params, extra);
      const auto expected =
          bruteForce(ours, theirs, plane ? CPose3D(pose_2d) : kPose, reach, plane);
      ASSERT_GT(expected.count, 20U);
      ASSERT_LT(expected.count, theirs.size());
      EXPECT_EQ(expected.count, pairs.size());
      const auto share = static_cast<double>(expected.count) / static_cast<double>(theirs.size());
      EXPECT_NEAR(share, extra.correspondencesRatio, 1e-6);
      double sum = 0;
      const auto points = pointsOf(*map.getAsSimplePointsMap());
      for (const auto& pair : pairs) {
        // The pairs hold the indices of the points of this map.
        const auto p = points.at(pair.globalIdx);
        EXPECT_NEAR(0, (p - TPoint3D(pair.global.x, pair.global.y, pair.global.z)).norm(), 1e-6);
        const auto q = plane ? CPose3D(pose_2d).composePoint(theirs.at(pair.localIdx))
                             : kPose.composePoint(theirs.at(pair.localIdx));
        sum += plane ? std::pow(std::hypot(p.x - q.x, p.y - q.y), 2) : (p - q).sqrNorm();
      }
      EXPECT_NEAR(expected.sum, sum, 1e-3 * expected.sum);
    }
  }
}

TEST(ProbOctoMapMatching, TakesMrptsParametersAsItsPointsDo) {
  const CProbOctoMap map(sceneTree(kResolution, 26));
  const CSimplePointsMap other = otherPoints(2);
  std::vector<TMatchingParams> variants(5);
  variants[1].onlyUniqueRobust = true;
  variants[2].decimation_other_map_points = 7;
  variants[2].offset_other_map_points = 3;
  variants[3].maxDistForCorrespondence = 0.1F;
  variants[3].maxAngularDistForCorrespondence = 0.1F;
  variants[3].angularDistPivotPoint = TPoint3D(1, 0, 0);
  variants[4].onlyKeepTheClosest = false;
  for (const auto& params : variants) {
    const CSimplePointsMap twin(*map.getAsSimplePointsMap());
    TMatchingPairList pairs, expected;
    TMatchingExtraResults extra, expected_extra;
    map.determineMatching3D(&other, kPose, pairs, params, extra);
    twin.determineMatching3D(&other, kPose, expected, params, expected_extra);
    EXPECT_FALSE(expected.empty());
    EXPECT_EQ(expected, pairs);
    EXPECT_EQ(expected_extra.correspondencesRatio, extra.correspondencesRatio);
    EXPECT_EQ(expected_extra.sumSqrDist, extra.sumSqrDist);
  }
}

TEST(ProbOctoMapMatching, TakesMapsOfEveryKindThatHasPoints) {
  const CProbOctoMap map(sceneTree(kResolution, 27));
  const auto ours = std::make_shared<CProbOctoMap>(sceneTree(kResolution, 28));
  const auto theirs = std::make_shared<COctoMap>(kResolution);
  ours->toOctoMap(*theirs);
  CMultiMetricMap with_ours, with_theirs, with_points;
  with_ours.maps.push_back(ours);
  with_theirs.maps.push_back(theirs);
  with_points.maps.push_back(std::make_shared<CSimplePointsMap>(*ours->getAsSimplePointsMap()));
  mrpt::maps::CPointsMapXYZI of_another_class;
  for (const auto& p : pointsOf(*ours->getAsSimplePointsMap())) of_another_class.insertPoint(p);

  TMatchingRatioParams params;
  params.maxDistForCorr = 0.12F;
  const auto expected = bruteForce(centresOf(map.octree()), centresOf(ours->octree()), kPose,
                                   params.maxDistForCorr, false);
  const double share =
      static_cast<double>(expected.count) / static_cast<double>(centresOf(ours->octree()).size());
  ASSERT_GT(share, 0.1);
  ASSERT_LT(share, 0.9);
  // Within float: a few pairs lie at just the distance.
  for (const mrpt::maps::CMetricMap* other : std::vector<const mrpt::maps::CMetricMap*>{
           ours.get(), theirs.get(), &with_ours, &with_theirs, &with_points, &of_another_class})
    EXPECT_NEAR(share, map.compute3DMatchingRatio(other, kPose, params), 1e-3)
        << other->GetRuntimeClass()->className;
  // A point map of MRPT takes our map, too.
  EXPECT_NEAR(share, map.getAsSimplePointsMap()->compute3DMatchingRatio(ours.get(), kPose, params),
              1e-3);
}

TEST(ProbOctoMapMatching, PointsBesideTheMapsBoxAreFoundToo) {
  // Point maps of MRPT find no pairs if the bounding boxes do not overlap.
  CProbOctoMap map(kResolution);
  CSimplePointsMap flat;
  for (int i = 0; i < 10; i++) {
    map.updateVoxel(0.1 * i + 0.05, 0.05, 0.05, true);
    flat.insertPoint(0.1F * static_cast<float>(i) + 0.05F, 0.05F, 0);
  }
  EXPECT_EQ(1, map.compute3DMatchingRatio(&flat, CPose3D(), {}));
  TMatchingPairList pairs;
  TMatchingExtraResults extra;
  map.determineMatching2D(&flat, CPose2D(0, 0.03, 0), pairs, {}, extra);
  EXPECT_EQ(10U, pairs.size());
}

TEST(ProbOctoMapMatching, WithNothingFindsNothing) {
  const CProbOctoMap map(sceneTree(kResolution, 29)), empty(kResolution);
  TMatchingPairList pairs;
  TMatchingExtraResults extra;
  EXPECT_EQ(0, map.compute3DMatchingRatio(&empty, kPose, {}));
  EXPECT_EQ(0, empty.compute3DMatchingRatio(&map, kPose, {}));
  empty.determineMatching2D(&map, CPose2D(), pairs, {}, extra);
  EXPECT_TRUE(pairs.empty());
}

TEST(ProbOctoMapMatching, AMapWithoutPointsIsNamed) {
  const CProbOctoMap map(smallTree());
  const mrpt::maps::COccupancyGridMap2D plane;
  TMatchingPairList pairs;
  TMatchingExtraResults extra;
  for (const auto& error :
       {errorOf([&] { map.determineMatching2D(&plane, CPose2D(), pairs, {}, extra); }),
        errorOf([&] { map.determineMatching3D(&plane, CPose3D(), pairs, {}, extra); }),
        errorOf([&] { map.compute3DMatchingRatio(&plane, CPose3D(), {}); })})
    EXPECT_NE(std::string::npos, error.find("COccupancyGridMap2D has no points to match with"))
        << error;
  EXPECT_ANY_THROW(map.determineMatching3D(nullptr, CPose3D(), pairs, {}, extra));
}

TEST(ProbOctoMapMatching, TheClosestObstacleInThePlaneIsThatOfBruteForce) {
  for (const unsigned seed : {30U, 31U}) {
    const CProbOctoMap map(sceneTree(kResolution, seed));
    const auto centres = centresOf(map.octree());
    std::mt19937 rng(seed);
    for (const float range : {2.5F, 30.0F, 1e5F}) {
      std::uniform_real_distribution<float> place(-range, range);
      for (int i = 0; i < 200; i++) {
        const float x = place(rng), y = place(rng);
        double expected = 1e30;
        for (const auto& c : centres)
          expected = std::min(expected, std::pow(c.x - x, 2) + std::pow(c.y - y, 2));
        ASSERT_NEAR(expected, map.squareDistanceToClosestCorrespondence(x, y),
                    1e-6 * expected + 1e-6)
            << x << " " << y;
      }
    }
  }
  EXPECT_ANY_THROW(CProbOctoMap(kResolution).squareDistanceToClosestCorrespondence(0, 0));
}

TEST(ProbOctoMapMatching, ManyThreadsMayAskAtOnce) {
  const CProbOctoMap map(sceneTree(kResolution, 32));
  const CSimplePointsMap other = otherPoints(3);
  const auto scan = cloudOf(domePoints(4));
  struct Answer {
    const CSimplePointsMap* points;
    float ratio, square_distance;
    double likelihood;
    bool operator==(const Answer& o) const {
      return points == o.points && ratio == o.ratio && square_distance == o.square_distance &&
             likelihood == o.likelihood;
    }
  };
  std::vector<Answer> answers(8);
  std::vector<std::thread> threads;
  for (auto& answer : answers)
    threads.emplace_back([&] {
      for (int i = 0; i < 20; i++) {
        answer.points = map.getAsSimplePointsMap();
        answer.ratio = map.compute3DMatchingRatio(&other, kPose, {});
        answer.square_distance = map.squareDistanceToClosestCorrespondence(1, 2);
        answer.likelihood = map.computeObservationLikelihood(*scan, kPose);
      }
    });
  for (auto& t : threads) t.join();
  for (const auto& answer : answers) EXPECT_TRUE(answer == answers.front());
  EXPECT_EQ(answers.front().points, map.getAsSimplePointsMap());
}
