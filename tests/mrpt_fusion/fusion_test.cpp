// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the shortest way from two maps to one. */
#include <gtest/gtest.h>
#include <mrpt/fusion/fusion.h>
#include <mrpt/fusion/voxels.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>

#include "support/apartment_pair.h"
#include "support/tree_tools.h"

namespace mrpt::fusion::test::fusion_test {
namespace {

using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;

class Fusing : public testing::Test {
 protected:
  static const ApartmentPair& pair() {
    static const ApartmentPair maps(0.2);
    return maps;
  }
  static CProbOctoMap mapOf(const octomap::OcTree& tree) {
    return CProbOctoMap(std::make_unique<octomap::OcTree>(tree));
  }
  static const CProbOctoMap& a() {
    static const CProbOctoMap map = mapOf(*pair().map_a);
    return map;
  }
  static const CProbOctoMap& b() {
    static const CProbOctoMap map = mapOf(*pair().map_b);
    return map;
  }
  /** A map of another place. */
  static CProbOctoMap elsewhere() {
    return mapOf(*MapWriter(0.2)
                      .box({0, 0, 0}, {60, 40, 0}, kOccupied)
                      .box({0, 0, 1}, {60, 40, 10}, kFree)
                      .pruned());
  }
  static size_t occupiedIn(const CProbOctoMap& map) { return statisticsOf(map.octree()).occupied; }
};

TEST_F(Fusing, TwoMapsThatMeetBecomeOne) {
  const Fused fused = fuse(a(), b());
  ASSERT_TRUE(fused.accepted()) << fused.why();
  EXPECT_LT(metresBetween(toEigen(fused.pose().mean), pair().truth), 0.1);
  EXPECT_LT(degreesBetween(toEigen(fused.pose().mean), pair().truth), 1);
  EXPECT_GT(occupiedIn(fused.map()), occupiedIn(a()));
  EXPECT_GT(occupiedIn(fused.map()), occupiedIn(b()));
  EXPECT_TRUE(fused.alignment().evaluation.accepted);
}

TEST_F(Fusing, TheFusedMapIsThatOfThePoseFound) {
  const Fused fused = fuse(a(), b());
  const auto expected = mergeMaps(a().octree(), b().octree(), fused.alignment().match.T_a_b, {});
  EXPECT_TRUE(map_tests::sameTree(fused.map().octree(), *expected));
  EXPECT_TRUE(toEigen(fused.pose().mean).isApprox(fused.alignment().match.T_a_b, 1e-12));
}

TEST_F(Fusing, WhyAnAcceptedMatchIsAcceptedAreAllReasonsOnOneLine) {
  const Fused fused = fuse(a(), b());
  const auto& reasons = fused.alignment().evaluation.reasons;
  ASSERT_GE(reasons.size(), 2U);
  EXPECT_EQ(fused.why().find(reasons[0] + "; " + reasons[1]), 0U) << fused.why();
  EXPECT_NE(fused.why().find(reasons.back()), std::string::npos);
  EXPECT_EQ(fused.why().find('\n'), std::string::npos);
}

TEST_F(Fusing, MapsThatDoNotMeetHaveNoFusedMap) {
  const Fused fused = fuse(a(), elsewhere());
  EXPECT_FALSE(fused.accepted());
  std::string against;
  for (const auto& reason : fused.alignment().evaluation.against())
    against += (against.empty() ? "" : "; ") + reason;
  ASSERT_FALSE(against.empty());
  EXPECT_EQ(fused.why(), against);
  try {
    fused.map();
    FAIL() << "nothing was merged";
  } catch (const std::logic_error& e) {
    EXPECT_NE(std::string(e.what()).find(fused.why()), std::string::npos) << e.what();
  }
}

TEST_F(Fusing, TheResultOutlivesTheMaps) {
  auto mine = std::make_unique<CProbOctoMap>(a()), other = std::make_unique<CProbOctoMap>(b());
  const Fused fused = fuse(*mine, *other);
  const size_t occupied = occupiedIn(fused.map());
  mine.reset();
  other.reset();
  const Fused copy = fused;  // NOLINT(performance-unnecessary-copy-initialization)
  EXPECT_EQ(occupiedIn(copy.map()), occupied);
  EXPECT_EQ(&copy.map(), &fused.map()) << "copies share the map";
}

TEST_F(Fusing, LeavesTheMapsAsTheyWere) {
  fuse(a(), b());
  EXPECT_TRUE(map_tests::sameTree(a().octree(), *pair().map_a));
  EXPECT_TRUE(map_tests::sameTree(b().octree(), *pair().map_b));
}

TEST_F(Fusing, GoesFromWhatIsKnownBefore) {
  const Prior right = Prior::near(toPose(pair().truth * poseOf(0.3, -0.2, 0, 4)));
  const Prior wrong = Prior::near(toPose(pair().truth * poseOf(30, 0, 0, 0)));
  EXPECT_TRUE(fuse(a(), b(), right).accepted());
  EXPECT_TRUE(fuse(a(), b(), wrong).accepted()) << "a guess is no worse than none";
  mrpt::poses::CPose3DPDFGaussian certain = wrong.pdf();
  certain.cov.setDiagonal(6, 0.01);
  EXPECT_FALSE(fuse(a(), b(), Prior::gaussian(certain)).accepted()) << "a covariance is believed";
}

TEST_F(Fusing, GoesByItsOptions) {
  Options strict;
  strict.evaluation.min_overlap = 1;
  EXPECT_FALSE(fuse(a(), b(), Prior::none(), strict).accepted());
}

TEST_F(Fusing, PreparedMapsGiveTheSameResult) {
  const PreparedMap prepared_a = prepare(a()), prepared_b = prepare(b());
  const Fused expected = fuse(a(), b());
  for (int i = 0; i < 2; i++) {
    const Fused fused = fuse(prepared_a, prepared_b);
    EXPECT_EQ(fused.alignment().match.T_a_b.matrix(), expected.alignment().match.T_a_b.matrix());
    EXPECT_TRUE(map_tests::sameTree(fused.map().octree(), expected.map().octree()));
  }
}

TEST_F(Fusing, EdgesAloneAreNotMerged) {
  const CEdgeVoxelMap edges(b());
  const Fused fused = fuse(a(), edges);
  EXPECT_FALSE(fused.accepted());
  EXPECT_TRUE(fused.alignment().by_edges);
  EXPECT_THROW(fused.map(), std::logic_error);
}

// ---------------------------------------------------------------- preparing

TEST_F(Fusing, PreparingAReferenceCopiesTheMap) {
  auto source = mapOf(*pair().map_a);
  const PreparedMap prepared = prepare(source);
  EXPECT_NE(prepared.octree().get(), &source.octree());
  source.octree().clear();
  EXPECT_TRUE(map_tests::sameTree(prepared.wholeMap(), *pair().map_a));
}

TEST_F(Fusing, PreparingASharedMapSharesItAndKeepsItAlive) {
  auto source = std::make_shared<CProbOctoMap>(a());
  const std::weak_ptr<CProbOctoMap> watched = source;
  {
    const PreparedMap prepared = prepare(std::shared_ptr<const CMetricMap>(source));
    EXPECT_EQ(prepared.octree().get(), &source->octree()) << "nothing is copied";
    source.reset();
    EXPECT_FALSE(watched.expired());
    EXPECT_TRUE(map_tests::sameTree(prepared.wholeMap(), *pair().map_a));
  }
  EXPECT_TRUE(watched.expired());
}

TEST_F(Fusing, PreparesAllKindsOfMapsAlike) {
  mrpt::maps::COctoMap octomap(0.2);
  a().toOctoMap(octomap);
  mrpt::maps::CMultiMetricMap several;
  several.maps.push_back(mrpt::maps::CSimplePointsMap::Create());  // not this one
  several.maps.push_back(std::make_shared<CProbOctoMap>(a()));
  const uint64_t expected = prepare(a()).contentHash();
  EXPECT_EQ(prepare(octomap).contentHash(), expected);
  EXPECT_EQ(prepare(several).contentHash(), expected);
}

TEST_F(Fusing, PreparesEdgesAsEdgesAlone) {
  const auto edges = std::make_shared<const CEdgeVoxelMap>(a());
  EXPECT_TRUE(prepare(*edges).isEdgesAlone());
  EXPECT_TRUE(prepare(std::shared_ptr<const CMetricMap>(edges)).isEdgesAlone());
  EXPECT_FALSE(prepare(a()).isEdgesAlone());
}

TEST_F(Fusing, PreparesWithTheParametersGiven) {
  FeatureParams params;
  params.voxel_spacing = 0.9;
  EXPECT_NE(prepare(a(), params).contentHash(), prepare(a()).contentHash());
}

TEST_F(Fusing, OtherKindsOfMapsAreRefusedByName) {
  const auto points = std::make_shared<const mrpt::maps::CSimplePointsMap>();
  const auto errorOf = [](auto&& call) { return map_tests::errorOf(call); };
  EXPECT_NE(errorOf([&] { prepare(*points); }).find("CSimplePointsMap"), std::string::npos);
  EXPECT_NE(
      errorOf([&] { prepare(std::shared_ptr<const CMetricMap>(points)); }).find("CSimplePointsMap"),
      std::string::npos);
  EXPECT_NE(errorOf([&] { fuse(*points, b()); }).find("CSimplePointsMap"), std::string::npos);
  EXPECT_THROW(prepare(std::shared_ptr<const CMetricMap>()), std::exception);
}

}  // namespace
}  // namespace mrpt::fusion::test::fusion_test
