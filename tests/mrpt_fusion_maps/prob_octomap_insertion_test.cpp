// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the octree after insertions: it is that of octomap, bit by bit, for all observations
 * that the map takes. */

#include <mrpt/obs/CObservationVelodyneScan.h>

#include <utility>

#include "support/mrpt_tools.h"
#include "support/observations.h"

using namespace map_tests;
using namespace mrpt::obs;
using mrpt::maps::CProbOctoMap;
using mrpt::poses::CPose3D;

namespace {

const std::vector<CPose3D> kRobotPath = {CPose3D(), CPose3D(1.23, -2.34, 0.57, 0.7, 0, 0),
                                         CPose3D(), CPose3D(-3.1, 0.4, -1.2, -2.1, 0.3, -0.25),
                                         CPose3D(0.1, 0, 0, 0, 0, 0)};

CObservationVelodyneScan::Ptr velodyneOf(const std::vector<mrpt::math::TPoint3Df>& points) {
  auto obs = CObservationVelodyneScan::Create();
  obs->sensorPose = kSensorPose;
  for (const auto& p : points) {
    obs->point_cloud.x.push_back(p.x);
    obs->point_cloud.y.push_back(p.y);
    obs->point_cloud.z.push_back(p.z);
    obs->point_cloud.intensity.push_back(0);
  }
  return obs;
}

/** Returns an observation of each kind that the map takes. */
std::vector<CObservation::Ptr> observations() {
  return {scan2d(kSensorPose), scan3dOf(domePoints(1, 3000), kSensorPose), depthImage(kSensorPose),
          cloudOf(domePoints(2, 3000), kSensorPose), velodyneOf(domePoints(3, 3000))};
}

/** Lets octomap do the next insertions: it visits all nodes if the tree was given away. */
void useOctomap(CProbOctoMap& map) { map.octree(); }

const octomap::OcTree& treeOf(const CProbOctoMap& map) { return map.octree(); }

}  // namespace

TEST(ProbOctoMapInsertion, GivesTheOctreeOfOctomapForAllKindsOfObservations) {
  for (const double max_range : {-1.0, 2.2})
    for (const bool pruning : {true, false}) {
      CProbOctoMap map(0.1), expected(0.1);
      useOctomap(expected);
      for (CProbOctoMap* one : {&map, &expected}) {
        one->insertionOptions.maxrange = max_range;
        one->insertionOptions.pruning = pruning;
      }
      for (const auto& pose : kRobotPath)
        for (const auto& obs : observations()) {
          ASSERT_TRUE(map.insertObservation(*obs, pose));
          ASSERT_TRUE(expected.insertObservation(*obs, pose));
          ASSERT_TRUE(sameTree(treeOf(expected), treeOf(map))) << obs->GetRuntimeClass()->className;
        }
      EXPECT_GT(map.size(), 3000U);
    }
}

TEST(ProbOctoMapInsertion, TheTreeMayChangeInOtherWaysBetweenInsertions) {
  CProbOctoMap map(0.1), expected(0.1);
  useOctomap(expected);
  const auto cloud = cloudOf(domePoints(4, 3000), kSensorPose);
  const auto insertIntoBoth = [&](const CPose3D& pose) {
    map.insertObservation(*cloud, pose);
    expected.insertObservation(*cloud, pose);
    return sameTree(treeOf(expected), treeOf(map));
  };
  ASSERT_TRUE(insertIntoBoth(kRobotPath[1]));
  for (CProbOctoMap* one : {&map, &expected}) one->insertionOptions.pruning = false;
  ASSERT_TRUE(insertIntoBoth(kRobotPath[0]));
  for (CProbOctoMap* one : {&map, &expected}) one->insertionOptions.pruning = true;
  ASSERT_TRUE(insertIntoBoth(kRobotPath[3]));
  for (CProbOctoMap* one : {&map, &expected}) {
    for (int i = 0; i < 300; i++) one->updateVoxel(0.01 * i, 0.3, 0.013 * i, i % 3 == 0);
    one->insertPointCloud(*cloud->pointcloud);
  }
  ASSERT_TRUE(insertIntoBoth(kRobotPath[4]));
  for (CProbOctoMap* one : {&map, &expected}) one->setOctree(awkwardTree(0.1));
  useOctomap(expected);
  ASSERT_TRUE(insertIntoBoth(kRobotPath[0]));
  ASSERT_TRUE(insertIntoBoth(kRobotPath[1]));
  const CProbOctoMap copy(map);
  map = copy;
  ASSERT_TRUE(insertIntoBoth(kRobotPath[2]));
  map.clear();
  expected.clear();
  ASSERT_TRUE(insertIntoBoth(kRobotPath[2]));
}

TEST(ProbOctoMapInsertion, ACallerWithTheTreeMayChangeAnyNodeAtAnyTime) {
  CProbOctoMap map(0.1);
  octomap::OcTree& tree = map.octree();
  const auto cloud = cloudOf(domePoints(5, 3000));
  for (int i = 0; i < 3; i++) {
    map.insertObservation(*cloud, kRobotPath[0]);
    tree.getRoot()->setLogOdds(7);
    tree.updateNode(octomap::point3d(-7, -7, static_cast<float>(i)), true, true);
    map.insertObservation(*cloud, kRobotPath[0]);
    octomap::OcTree updated(tree);
    updated.updateInnerOccupancy();
    updated.prune();
    EXPECT_TRUE(sameTree(updated, tree));
  }
}
