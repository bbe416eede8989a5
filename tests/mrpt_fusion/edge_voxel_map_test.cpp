// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/fusion/poses.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/opengl/CSetOfLines.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>

#include <limits>
#include <sstream>

#include "fusion_core/map/map_voxels.h"
#include "support/apartment_pair.h"

namespace mrpt::fusion::test::edge_voxel_map_test {
namespace {

using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CProbOctoMap;
using mrpt::slam::CProbabilisticMapMatching;

std::string serialized(const mrpt::serialization::CSerializable& object) {
  mrpt::io::CMemoryStream memory;
  mrpt::serialization::archiveFrom(memory) << object;
  return {static_cast<const char*>(memory.getRawBufferData()),
          static_cast<size_t>(memory.getTotalBytesCount())};
}

void deserializeInto(const std::string& bytes, mrpt::serialization::CSerializable& object) {
  mrpt::io::CMemoryStream memory;
  memory.assignMemoryNotOwn(bytes.data(), bytes.size());
  mrpt::serialization::archiveFrom(memory) >> object;
}

void expectSame(const EdgeVoxels& a, const EdgeVoxels& b) {
  EXPECT_EQ(a.resolution, b.resolution);
  EXPECT_EQ(a.direction_radius, b.direction_radius);
  EXPECT_EQ(a.centre, b.centre);
  EXPECT_EQ(a.probability, b.probability);
  ASSERT_EQ(a.covariance.size(), b.covariance.size());
  for (size_t i = 0; i < a.size(); i++) {
    EXPECT_EQ(a.covariance[i].eigenvalues, b.covariance[i].eigenvalues) << i;
    EXPECT_EQ(a.covariance[i].eigenvectors, b.covariance[i].eigenvectors) << i;
  }
}

/** The apartment's maps, made once. */
const ApartmentPair& apartments() {
  static const ApartmentPair pair(0.1);
  return pair;
}
const CProbOctoMap& mapA() {
  static const CProbOctoMap map(std::make_unique<octomap::OcTree>(*apartments().map_a));
  return map;
}
const CProbOctoMap& mapB() {
  static const CProbOctoMap map(std::make_unique<octomap::OcTree>(*apartments().map_b));
  return map;
}

TEST(EdgeVoxelMap, HasTheEdgesOfAlgorithm1) {
  const CEdgeVoxelMap edges(mapA());
  ASSERT_GT(edges.size(), 100U);
  expectSame(edges.edges(), extractEdges(extractOccupiedVoxels(mapA().octree()), EdgeParams()));
}

TEST(EdgeVoxelMap, IsTheSameToTheBitAfterASaveAndALoad) {
  EdgeParams params;
  params.direction_radius = 0.7;
  CEdgeVoxelMap edges(mapA(), params);
  edges.genericMapParams.enableSaveAs3DObject = false;
  CEdgeVoxelMap read;
  deserializeInto(serialized(edges), read);
  expectSame(read.edges(), edges.edges());
  EXPECT_EQ(read.edges().direction_radius, 0.7);
  EXPECT_FALSE(read.genericMapParams.enableSaveAs3DObject);
}

TEST(EdgeVoxelMap, OfVoxelsOfTwoMillimetresIsReadAgain) {
  EdgeVoxels fine;
  fine.resolution = 0.002;
  fine.direction_radius = EdgeParams().direction_radius;
  fine.centre = {{0.101F, 0.101F, 0.101F}, {0.103F, 0.101F, 0.101F}, {0.105F, 0.101F, 0.101F}};
  fine.probability = {0.7F, 0.7F, 0.7F};
  const CEdgeVoxelMap edges(fine);
  EXPECT_EQ(edges.edges().direction_radius, 64 * fine.resolution);
  CEdgeVoxelMap read;
  deserializeInto(serialized(edges), read);
  ASSERT_EQ(read.size(), 3U);
  expectSame(read.edges(), edges.edges());
}

TEST(EdgeVoxelMap, IsAFractionOfTheMap) {
  EXPECT_LT(serialized(CEdgeVoxelMap(mapA())).size(), serialized(mapA()).size() / 50);
}

TEST(EdgeVoxelMap, AnEmptyOneStaysEmpty) {
  CEdgeVoxelMap read(mapA());
  deserializeInto(serialized(CEdgeVoxelMap()), read);
  EXPECT_TRUE(read.isEmpty());
  EXPECT_EQ(CEdgeVoxelMap(CProbOctoMap(0.1)).size(), 0U);
  EXPECT_EQ(read.asOcTree().size(), 0U);
}

TEST(EdgeVoxelMap, WhatIsNoEdgeVoxelThrows) {
  EdgeVoxels edges;
  edges.resolution = 0.1;
  edges.covariance.resize(1);
  const auto with = [&](const Eigen::Vector3f& centre, float probability) {
    edges.centre = {centre};
    edges.probability = {probability};
    return CEdgeVoxelMap(edges);
  };
  EXPECT_EQ(with({1, 2, 3}, 0.7F).size(), 1U);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(with({nan, 2, 3}, 0.7F), std::exception);
  EXPECT_THROW(with({1e6F, 2, 3}, 0.7F), std::exception);
  EXPECT_THROW(with({1, 2, 3}, nan), std::exception);
  EXPECT_THROW(with({1, 2, 3}, 0.F), std::exception);
  EXPECT_THROW(with({1, 2, 3}, 1.1F), std::exception);
  edges.resolution = 0;
  EXPECT_THROW(with({1, 2, 3}, 0.7F), std::exception);
}

TEST(EdgeVoxelMap, ATruncatedOrNewerStreamThrowsAndLeavesTheTargetAsItWas) {
  const std::string bytes = serialized(CEdgeVoxelMap(mapA()));
  CEdgeVoxelMap target(mapB());
  const EdgeVoxels before = target.edges();
  for (size_t n = 0; n + 1 < bytes.size(); n += 1 + n / 40)
    ASSERT_THROW(deserializeInto(bytes.substr(0, n), target), std::exception) << n;
  std::string newer = bytes;
  const std::string name = "CEdgeVoxelMap";
  newer[newer.find(name) + name.size()] = 1;
  EXPECT_THROW(deserializeInto(newer, target), std::exception);
  expectSame(target.edges(), before);
}

TEST(EdgeVoxelMap, IsDrawnAsLinesAlongTheEdges) {
  CEdgeVoxelMap edges(mapA());
  mrpt::opengl::CSetOfObjects scene;
  edges.getVisualizationInto(scene);
  const auto lines = scene.getByClass<mrpt::opengl::CSetOfLines>();
  ASSERT_TRUE(lines);
  ASSERT_EQ(lines->getLineCount(), edges.size());
  for (size_t i = 0; i < edges.size(); i += 10) {
    double x0, y0, z0, x1, y1, z1;
    lines->getLineByIndex(i, x0, y0, z0, x1, y1, z1);
    const Eigen::Vector3d from(x0, y0, z0), to(x1, y1, z1);
    EXPECT_LT((0.5 * (from + to) - edges.edges().centre[i].cast<double>()).norm(), 1e-5);
    EXPECT_GT(std::abs((to - from).normalized().dot(edges.edges().covariance[i].direction())),
              0.999);
  }
}

TEST(EdgeVoxelMap, TakesNoObservations) {
  CEdgeVoxelMap edges(mapA());
  const mrpt::obs::CObservationRobotPose o;
  EXPECT_FALSE(edges.insertObservation(o));
  EXPECT_FALSE(edges.canComputeObservationLikelihood(o));
}

// ---------------------------------------------------------------- matching by edges

double errorAt(const mrpt::poses::CPose3DPDF& pose) {
  const Eigen::Isometry3d T = toEigen(pose.getMeanVal());
  const Eigen::Vector3d middle = meanOf(apartments().b.voxels.centre);
  return (T * middle - apartments().truth * middle).norm();
}

TEST(MatchingByEdges, FindsThePoseOfEdgesInAMap) {
  CProbabilisticMapMatching pmm;
  const CEdgeVoxelMap edges_b(mapB());
  CProbabilisticMapMatching::TReturnInfo info;
  const auto guess = toPose(poseOf(0.4, -0.5, 0.1, 6, 0, 0) * apartments().truth);
  const auto pose = pmm.Align3D(&mapA(), &edges_b, guess, info);
  EXPECT_LT(errorAt(*pose), 0.1);
  EXPECT_TRUE(info.by_edges);
  EXPECT_EQ(info.voxels_b, edges_b.size());
  EXPECT_FALSE(info.evaluation.accepted) << "there is nothing to merge";
  ASSERT_GT(info.evaluation.reasons_against, 0U);
  EXPECT_NE(info.evaluation.reasons[info.evaluation.reasons_against - 1].find("edges alone"),
            std::string::npos);
}

TEST(MatchingByEdges, FindsThePoseOfAMapInEdges) {
  CProbabilisticMapMatching pmm;
  const CEdgeVoxelMap edges_a(mapA());
  CProbabilisticMapMatching::TReturnInfo info;
  const auto guess = toPose(poseOf(0.4, -0.5, 0.1, 6, 0, 0) * apartments().truth);
  EXPECT_LT(errorAt(*pmm.Align3D(&edges_a, &mapB(), guess, info)), 0.1);
  EXPECT_TRUE(info.by_edges);
}

TEST(MatchingByEdges, NeedsEdges) {
  CProbabilisticMapMatching pmm;
  const CEdgeVoxelMap none;
  EXPECT_THROW(pmm.Align3D(&mapA(), &none, {}), std::exception);
  EXPECT_THROW(pmm.Align3D(&none, &mapB(), {}), std::exception);
}

TEST(MatchingByEdges, EdgesAreNotMerged) {
  const CProbabilisticMapMatching pmm;
  const CEdgeVoxelMap edges_b(mapB());
  EXPECT_THROW(pmm.merge(mapA(), edges_b, {}), std::exception);
}

}  // namespace
}  // namespace mrpt::fusion::test::edge_voxel_map_test
