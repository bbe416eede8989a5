// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of maps that are prepared once and matched many times. */
#include <gtest/gtest.h>
#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/prepared_map.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "fusion_core/features/features.h"
#include "support/apartment_pair.h"
#include "support/tree_tools.h"

namespace mrpt::fusion::test::prepared_map_test {
namespace {

const ApartmentPair& maps() {
  static const ApartmentPair pair(0.2);
  return pair;
}
Prior nearTheTruth() { return Prior::near(toPose(maps().truth * poseOf(0.3, -0.2, 0, 4))); }

PreparedMap preparedA() { return PreparedMap(*maps().map_a); }
PreparedMap preparedB() { return PreparedMap(*maps().map_b); }

/** Some voxels, so that preparing takes no time. */
std::unique_ptr<octomap::OcTree> smallMap(float log_odds = kOccupied, double resolution = 0.1) {
  return MapWriter(resolution)
      .box({0, 0, 0}, {9, 0, 9}, kOccupied)
      .box({0, 1, 0}, {9, 9, 9}, kFree)
      .voxel({5, 5, 5}, log_odds)
      .pruned();
}

bool sameFeatures(const MapFeatures& f, const MapFeatures& g) {
  return f.voxels.centre == g.voxels.centre && f.matched.voxels.key == g.matched.voxels.key &&
         f.matched.surfaces.normal == g.matched.surfaces.normal &&
         f.edges.centre == g.edges.centre && f.edges.probability == g.edges.probability;
}

void expectSameBits(const Alignment& a, const Alignment& b) {
  EXPECT_EQ(a.match.T_a_b.matrix(), b.match.T_a_b.matrix());
  EXPECT_EQ(a.match.covariance, b.match.covariance);
  EXPECT_EQ(a.match.iterations.size(), b.match.iterations.size());
  ASSERT_EQ(a.match.hypotheses.size(), b.match.hypotheses.size());
  for (size_t i = 0; i < a.match.hypotheses.size(); i++)
    EXPECT_EQ(a.match.hypotheses[i].agreement, b.match.hypotheses[i].agreement);
  ASSERT_EQ(a.match.pairs.size(), b.match.pairs.size());
  for (size_t i = 0; i < a.match.pairs.size(); i++)
    ASSERT_EQ(a.match.pairs[i].a, b.match.pairs[i].a);
  EXPECT_EQ(a.evaluation.probability, b.evaluation.probability);
}

// ---------------------------------------------------------------- ownership

TEST(PreparedMap, OutlivesTheMapItWasMadeOf) {
  auto source = std::make_unique<octomap::OcTree>(*maps().map_a);
  const PreparedMap prepared(*source);
  const size_t voxels = prepared.occupiedVoxels();
  source->clear();
  source.reset();
  EXPECT_TRUE(map_tests::sameTree(*prepared.octree(), *maps().map_a));
  EXPECT_EQ(prepared.occupiedVoxels(), voxels);
  EXPECT_TRUE(align(prepared, preparedB(), nearTheTruth(), {}).evaluation.accepted);
}

TEST(PreparedMap, OutlivesTheCopyItWasCopiedFrom) {
  auto first = std::make_unique<PreparedMap>(*smallMap());
  const PreparedMap copy = *first;
  const uint64_t hash = first->contentHash();
  first.reset();
  EXPECT_EQ(copy.contentHash(), hash);
  EXPECT_EQ(extractOccupiedVoxels(copy.wholeMap()).size(), copy.occupiedVoxels());
}

TEST(PreparedMap, SharesAMapThatIsShared) {
  const std::shared_ptr<const octomap::OcTree> source = smallMap();
  const PreparedMap prepared(source);
  EXPECT_EQ(prepared.octree(), source);
  EXPECT_EQ(&prepared.wholeMap(), source.get());
  EXPECT_NE(PreparedMap(*source).octree(), source) << "copied";
}

TEST(PreparedMap, CopiesShareOctreeAndFeatures) {
  const size_t before = featureExtractions();
  const PreparedMap prepared(*smallMap());
  EXPECT_EQ(featureExtractions(), before + 1);
  const PreparedMap copy = prepared;
  std::vector<PreparedMap> many(10, copy);
  EXPECT_EQ(&many.back().features(), &prepared.features());
  EXPECT_EQ(&many.back().featuresByEdges(), &prepared.featuresByEdges());
  EXPECT_EQ(many.back().octree(), prepared.octree());
  EXPECT_EQ(featureExtractions(), before + 1) << "nothing is prepared again";
}

TEST(PreparedMap, HasTheFeaturesOfItsParameters) {
  FeatureParams all;
  all.voxel_spacing = 0;
  EXPECT_TRUE(sameFeatures(PreparedMap(*maps().map_a, all).features(),
                           computeFeatures(borrowed(*maps().map_a), all)));
  EXPECT_TRUE(sameFeatures(preparedA().features(), computeFeatures(borrowed(*maps().map_a), {})));
  EXPECT_GT(PreparedMap(*maps().map_a, all).features().matched.voxels.size(), 0U);
  EXPECT_EQ(preparedA().edges().centre, preparedA().features().edges.centre);
  EXPECT_EQ(preparedA().occupiedVoxels(), maps().a.voxels.size());
}

// ---------------------------------------------------------------- the hash

TEST(PreparedMapHash, IsThatOfTheContentNotOfThePlace) {
  EXPECT_EQ(PreparedMap(*smallMap()).contentHash(), PreparedMap(*smallMap()).contentHash());
  EXPECT_EQ(PreparedMap(octomap::OcTree(0.1)).contentHash(),
            PreparedMap(octomap::OcTree(0.1)).contentHash());
}

TEST(PreparedMapHash, DiffersIfAnythingOfTheMapDoes) {
  std::set<uint64_t> hashes;
  const auto add = [&](const octomap::OcTree& map) {
    hashes.insert(PreparedMap(map).contentHash());
  };
  add(*smallMap());
  add(*smallMap(std::nextafter(kOccupied, 9.F)));          // the last bit of a log-odds
  add(*smallMap(kFree));                                   // pruned otherwise
  add(*smallMap(kOccupied, 0.2));                          // resolution
  add(*MapWriter().voxel({5, 5, 5}, kOccupied).pruned());  // structure
  add(*MapWriter().voxel({5, 5, 6}, kOccupied).pruned());
  add(octomap::OcTree(0.1));
  add(octomap::OcTree(0.2));
  EXPECT_EQ(hashes.size(), 8U);
}

TEST(PreparedMapHash, DiffersIfAParameterDoes) {
  const auto map = smallMap();
  std::set<uint64_t> hashes;
  FeatureParams params;
  const auto add = [&] { hashes.insert(PreparedMap(*map, params).contentHash()); };
  add();
  params.voxel_spacing = 0.3;
  add();
  params.edge_spacing = 0.3;
  add();
  params.edges.kappa = 0.4;
  add();
  params.edges.outlier_neighbours = 9;
  add();
  EXPECT_EQ(hashes.size(), 5U);
}

// ---------------------------------------------------------------- edges alone

TEST(PreparedEdges, AreNoWholeMap) {
  const PreparedMap edges(maps().a.edges);
  EXPECT_TRUE(edges.isEdgesAlone());
  EXPECT_THROW(edges.wholeMap(), std::exception);
  ASSERT_TRUE(edges.octree());
  EXPECT_EQ(edges.occupiedVoxels(), maps().a.edges.size());
  EXPECT_EQ(edges.edges().centre, maps().a.edges.centre);
  EXPECT_FALSE(preparedA().isEdgesAlone());
  EXPECT_NO_THROW(preparedA().wholeMap());
}

TEST(PreparedEdges, AreComparedByTheSameFeaturesAsAMap) {
  const PreparedMap edges(maps().a.edges);
  EXPECT_EQ(&edges.featuresByEdges(), &edges.features());
  const PreparedMap whole = preparedA();
  EXPECT_NE(&whole.featuresByEdges(), &whole.features());
  EXPECT_EQ(whole.featuresByEdges().voxels.size(), whole.features().voxels.size());
  EXPECT_LT(whole.featuresByEdges().matched.voxels.size(), whole.features().voxels.size());
}

TEST(PreparedMap, OfNothingIsRefused) {
  EXPECT_THROW(PreparedMap(std::shared_ptr<const octomap::OcTree>()), std::invalid_argument);
}

// ---------------------------------------------------------------- used many times

TEST(PreparedMap, GivesTheSameBitsEachTimeItIsMatched) {
  const Alignment anew = align(preparedA(), preparedB(), nearTheTruth(), {});
  ASSERT_TRUE(anew.evaluation.accepted);
  const PreparedMap a = preparedA(), b = preparedB();
  for (int i = 0; i < 3; i++) {
    expectSameBits(align(a, b, nearTheTruth(), {}), anew);
    align(b, a, Prior::near(toPose(maps().truth.inverse())), {});
    align(a, a, Prior::near({}), {});
  }
}

TEST(PreparedMap, MayBeUsedBySeveralThreads) {
  const PreparedMap a = preparedA(), b = preparedB();
  const PreparedMap edges_b(maps().b.edges);
  const Alignment expected = align(preparedA(), preparedB(), nearTheTruth(), {});
  const Alignment expected_by_edges = align(preparedA(), edges_b, nearTheTruth(), {});
  const uint64_t hash = preparedA().contentHash();
  std::vector<Alignment> matches(3), by_edges(3);
  std::vector<uint64_t> hashes(3);
  std::vector<std::thread> threads;
  for (size_t i = 0; i < 3; i++)
    threads.emplace_back([&, i] {
      hashes[i] = a.contentHash();
      by_edges[i] = align(a, edges_b, nearTheTruth(), {});
      matches[i] = align(a, b, nearTheTruth(), {});
    });
  for (std::thread& t : threads) t.join();
  for (size_t i = 0; i < 3; i++) {
    EXPECT_EQ(hashes[i], hash);
    expectSameBits(matches[i], expected);
    expectSameBits(by_edges[i], expected_by_edges);
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::prepared_map_test
