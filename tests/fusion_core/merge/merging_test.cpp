// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/fusion/merging.h>
#include <mrpt/fusion/voxels.h>

#include <cmath>
#include <optional>
#include <random>

#include "fusion_octree/build.h"
#include "fusion_octree/files.h"
#include "support/reference_merging.h"
#include "support/test_maps.h"
#include "support/tree_tools.h"

namespace mrpt::fusion::test::merging_test {
namespace {

using mrpt::fusion::OcTreeAccess;
using mrpt::fusion::serializeNodes;
using octomap::OcTree;

const MergeParams kRelativeEntropy{MergePolicy::RelativeEntropy, 0.1};
constexpr MergePolicy kPolicies[] = {MergePolicy::RelativeEntropy, MergePolicy::Average,
                                     MergePolicy::Stitch, MergePolicy::Bayes};

float logOdds(double p) { return static_cast<float>(std::log(p / (1 - p))); }
double probability(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }

MergeParams by(MergePolicy policy) {
  MergeParams params;
  params.policy = policy;
  return params;
}

/** fuseLogOdds() in probabilities, with OctoMap's default clamping. */
double fuse(double a, double b, MergePolicy policy) {
  return probability(fuseLogOdds(logOdds(a), logOdds(b), by(policy), -2.F, 3.5F));
}

/** What a map holds at a cell of its grid; nothing if unknown. */
std::optional<double> probabilityAt(const OcTree& map, const Cell& c) {
  const auto* node = map.search(keyOf(c));
  return node ? std::optional<double>(node->getOccupancy()) : std::nullopt;
}

void expectAt(const OcTree& map, const Cell& c, double p) {
  const auto found = probabilityAt(map, c);
  ASSERT_TRUE(found) << "unknown at " << c[0] << " " << c[1] << " " << c[2];
  EXPECT_NEAR(*found, p, 1e-5) << c[0] << " " << c[1] << " " << c[2];
}

// ---------------------------------------------------------------- eqs. (27), (28)

TEST(RelativeEntropy, ByHand) {
  EXPECT_NEAR(relativeEntropy(0.5, 0.25), 0.5 * std::log(2.0) + 0.5 * std::log(0.5 / 0.75), 1e-12);
  EXPECT_NEAR(relativeEntropy(0.9, 0.6), 0.9 * std::log(1.5) + 0.1 * std::log(0.25), 1e-12);
  EXPECT_EQ(relativeEntropy(0.7, 0.7), 0);
}

TEST(RelativeEntropy, IsNotSymmetricAndNeverNegative) {
  EXPECT_GT(relativeEntropy(0.85, 0.97), relativeEntropy(0.97, 0.85));
  for (double p = 0; p <= 1; p += 0.05)
    for (double q = 0; q <= 1; q += 0.05) EXPECT_GE(relativeEntropy(p, q), 0) << p << " " << q;
}

TEST(RelativeEntropy, IsFiniteAtCertainty) {
  EXPECT_EQ(relativeEntropy(0, 0), 0);
  EXPECT_EQ(relativeEntropy(1, 1), 0);
  EXPECT_NEAR(relativeEntropy(1, 0), std::log(1e6), 1e-3);
  EXPECT_NEAR(relativeEntropy(0, 1), std::log(1e6), 1e-3);
  EXPECT_NEAR(relativeEntropy(1, 0.5), std::log(2.0), 1e-4);
}

TEST(WeightedMean, ByHand) {
  EXPECT_DOUBLE_EQ(weightedMean(0.8, 0.4), (0.64 + 0.16) / 1.2);
  EXPECT_DOUBLE_EQ(weightedMean(0.3, 0.3), 0.3);
  EXPECT_EQ(weightedMean(0, 0), 0);
}

TEST(WeightedMean, LiesBetweenTheMeanAndTheHigher) {
  for (double p = 0.05; p < 1; p += 0.1)
    for (double q = 0.05; q < 1; q += 0.1) {
      EXPECT_GE(weightedMean(p, q), 0.5 * (p + q) - 1e-12);
      EXPECT_LE(weightedMean(p, q), std::max(p, q) + 1e-12);
      EXPECT_DOUBLE_EQ(weightedMean(p, q), weightedMean(q, p));
    }
}

// ---------------------------------------------------------------- one voxel

TEST(FuseLogOdds, RelativeEntropyAveragesWhatIsSimilar) {
  EXPECT_NEAR(fuse(0.9, 0.85, MergePolicy::RelativeEntropy), (0.81 + 0.7225) / 1.75, 1e-6);
  EXPECT_NEAR(fuse(0.2, 0.15, MergePolicy::RelativeEntropy), (0.04 + 0.0225) / 0.35, 1e-6);
}

TEST(FuseLogOdds, RelativeEntropyTrustsTheHigherOfWhatIsNot) {
  for (const auto& [a, b] : {std::pair{0.97, 0.6}, {0.9, 0.2}, {0.4, 0.12}}) {
    EXPECT_NEAR(fuse(a, b, MergePolicy::RelativeEntropy), a, 1e-6);
    EXPECT_NEAR(fuse(b, a, MergePolicy::RelativeEntropy), a, 1e-6);
  }
}

TEST(FuseLogOdds, RelativeEntropyIsOfTheModelAgainstTheScene) {
  // Below the threshold one way, 0.080, and above it the other, 0.129.
  EXPECT_NEAR(fuse(0.97, 0.85, MergePolicy::RelativeEntropy), weightedMean(0.97, 0.85), 1e-6);
  EXPECT_NEAR(fuse(0.85, 0.97, MergePolicy::RelativeEntropy), 0.97, 1e-6);
  MergeParams wider = kRelativeEntropy;
  wider.kl_threshold = 0.13;
  EXPECT_NEAR(probability(fuseLogOdds(logOdds(0.85), logOdds(0.97), wider, -2.F, 3.5F)),
              weightedMean(0.97, 0.85), 1e-6);
}

TEST(FuseLogOdds, AverageIsTheMeanProbability) {
  EXPECT_NEAR(fuse(0.9, 0.2, MergePolicy::Average), 0.55, 1e-6);
  EXPECT_NEAR(fuse(0.2, 0.9, MergePolicy::Average), 0.55, 1e-6);
}

TEST(FuseLogOdds, StitchKeepsTheModel) {
  EXPECT_EQ(fuseLogOdds(0.7F, 3.F, by(MergePolicy::Stitch), -2.F, 3.5F), 0.7F);
  EXPECT_EQ(fuseLogOdds(3.F, 0.7F, by(MergePolicy::Stitch), -2.F, 3.5F), 3.F);
}

TEST(FuseLogOdds, BayesAddsUpWithinTheClampingThresholds) {
  const auto bayes = [](float a, float b) {
    return fuseLogOdds(a, b, by(MergePolicy::Bayes), -2.F, 3.5F);
  };
  EXPECT_FLOAT_EQ(bayes(1.F, 1.5F), 2.5F);
  EXPECT_FLOAT_EQ(bayes(2.F, -0.5F), 1.5F);
  EXPECT_EQ(bayes(3.F, 2.F), 3.5F);
  EXPECT_EQ(bayes(-1.5F, -1.F), -2.F);
  // A voxel that was beyond them (another sensor model) is not weakened by one that agrees.
  EXPECT_EQ(bayes(5.F, 1.F), 5.F);
  EXPECT_EQ(bayes(1.F, 5.F), 5.F);
  EXPECT_EQ(bayes(-4.F, -1.F), -4.F);
  EXPECT_FLOAT_EQ(bayes(5.F, -3.F), 2.F);
}

TEST(FuseLogOdds, OfEqualValuesIsThatValueBitForBit) {
  for (const auto policy :
       {MergePolicy::RelativeEntropy, MergePolicy::Average, MergePolicy::Stitch})
    for (const float v : {-30.F, -2.F, -0.123F, 0.F, 0.456F, 3.5F, 30.F})
      EXPECT_EQ(fuseLogOdds(v, v, by(policy), -2.F, 3.5F), v);
}

TEST(FuseLogOdds, NeverLeavesTheRangeOfItsInputsUnlessItAddsThemUp) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(-10, 10);
  for (int i = 0; i < 500; i++) {
    const float a = u(random), b = u(random);
    for (const auto policy :
         {MergePolicy::RelativeEntropy, MergePolicy::Average, MergePolicy::Stitch}) {
      const float fused = fuseLogOdds(a, b, by(policy), -2.F, 3.5F);
      EXPECT_GE(fused, std::min(a, b) - 1e-4F);
      EXPECT_LE(fused, std::max(a, b) + 1e-4F);
    }
  }
}

// ---------------------------------------------------------------- whole maps

/** One voxel for each case: what A has, what B has, and the place. */
constexpr Cell kBothSimilar{0, 0, 0}, kAHigher{1, 0, 0}, kBHigher{2, 0, 0}, kOnlyAOccupied{3, 0, 0},
    kOnlyBOccupied{4, 0, 0}, kBothFree{5, 0, 0}, kKnownToA{6, 0, 0}, kFreeInA{7, 0, 0},
    kKnownToB{8, 0, 0}, kFreeInB{9, 0, 0}, kUnknown{10, 0, 0};

class MergedMaps : public testing::Test {
 protected:
  std::unique_ptr<OcTree> merged(MergePolicy policy) const {
    return mergeMaps(*a, *b, kIdentity, by(policy));
  }
  /** What holds whatever the policy. */
  static void expectOneSidedAsTheyWere(const OcTree& fused) {
    expectAt(fused, kKnownToA, 0.75);
    expectAt(fused, kFreeInA, 0.3);
    expectAt(fused, kKnownToB, 0.8);
    expectAt(fused, kFreeInB, 0.35);
    EXPECT_FALSE(probabilityAt(fused, kUnknown));
    EXPECT_EQ(fused.getNumLeafNodes(), 10);
  }

  const std::unique_ptr<OcTree> a = MapWriter()
                                        .voxel(kBothSimilar, logOdds(0.9))
                                        .voxel(kAHigher, logOdds(0.97))
                                        .voxel(kBHigher, logOdds(0.6))
                                        .voxel(kOnlyAOccupied, logOdds(0.9))
                                        .voxel(kOnlyBOccupied, logOdds(0.2))
                                        .voxel(kBothFree, logOdds(0.2))
                                        .voxel(kKnownToA, logOdds(0.75))
                                        .voxel(kFreeInA, logOdds(0.3))
                                        .pruned();
  const std::unique_ptr<OcTree> b = MapWriter()
                                        .voxel(kBothSimilar, logOdds(0.85))
                                        .voxel(kAHigher, logOdds(0.6))
                                        .voxel(kBHigher, logOdds(0.97))
                                        .voxel(kOnlyAOccupied, logOdds(0.2))
                                        .voxel(kOnlyBOccupied, logOdds(0.9))
                                        .voxel(kBothFree, logOdds(0.15))
                                        .voxel(kKnownToB, logOdds(0.8))
                                        .voxel(kFreeInB, logOdds(0.35))
                                        .pruned();
};

TEST_F(MergedMaps, ByRelativeEntropy) {
  const auto fused = merged(MergePolicy::RelativeEntropy);
  expectAt(*fused, kBothSimilar, (0.81 + 0.7225) / 1.75);
  expectAt(*fused, kAHigher, 0.97);
  expectAt(*fused, kBHigher, 0.97);
  expectAt(*fused, kOnlyAOccupied, 0.9);
  expectAt(*fused, kOnlyBOccupied, 0.9);
  expectAt(*fused, kBothFree, (0.04 + 0.0225) / 0.35);
  expectOneSidedAsTheyWere(*fused);
}

TEST_F(MergedMaps, ByAverage) {
  const auto fused = merged(MergePolicy::Average);
  expectAt(*fused, kBothSimilar, 0.875);
  expectAt(*fused, kAHigher, 0.785);
  expectAt(*fused, kBHigher, 0.785);
  expectAt(*fused, kOnlyAOccupied, 0.55);
  expectAt(*fused, kOnlyBOccupied, 0.55);
  expectAt(*fused, kBothFree, 0.175);
  expectOneSidedAsTheyWere(*fused);
}

TEST_F(MergedMaps, ByStitching) {
  const auto fused = merged(MergePolicy::Stitch);
  expectAt(*fused, kBothSimilar, 0.9);
  expectAt(*fused, kAHigher, 0.97);
  expectAt(*fused, kBHigher, 0.6);
  expectAt(*fused, kOnlyAOccupied, 0.9);
  expectAt(*fused, kOnlyBOccupied, 0.2);
  expectAt(*fused, kBothFree, 0.2);
  expectOneSidedAsTheyWere(*fused);
}

TEST_F(MergedMaps, ByBayes) {
  const auto fused = merged(MergePolicy::Bayes);
  const double upper = a->getClampingThresMax(), lower = a->getClampingThresMin();
  expectAt(*fused, kBothSimilar, upper);  // odds 9 * 5.67
  expectAt(*fused, kAHigher, upper);
  expectAt(*fused, kBHigher, upper);
  expectAt(*fused, kOnlyAOccupied, 2.25 / 3.25);  // odds 9 * 0.25
  expectAt(*fused, kOnlyBOccupied, 2.25 / 3.25);
  expectAt(*fused, kBothFree, lower);  // odds 0.25 * 0.176
  expectOneSidedAsTheyWere(*fused);
}

TEST_F(MergedMaps, InputsAreNotTouched) {
  const std::string a_before = serializeNodes(*a), b_before = serializeNodes(*b);
  for (const auto policy : kPolicies) mergeMaps(*a, *b, poseOf(0.13, 0.2, 0, 30, 5, 0), by(policy));
  EXPECT_EQ(serializeNodes(*a), a_before);
  EXPECT_EQ(serializeNodes(*b), b_before);
}

TEST_F(MergedMaps, KeepTheSensorModelAndResolutionOfTheModel) {
  OcTreeAccess::setSensorModel(*a, {-3.3F, 4.4F, 1.1F, -0.7F, 0.25F});
  b->setProbHit(0.9);
  const auto fused = merged(MergePolicy::Bayes);
  const auto model = OcTreeAccess::sensorModel(*fused);
  EXPECT_EQ(model.clamp_min, -3.3F);
  EXPECT_EQ(model.clamp_max, 4.4F);
  EXPECT_EQ(model.hit, 1.1F);
  EXPECT_EQ(model.miss, -0.7F);
  EXPECT_EQ(model.occupancy_threshold, 0.25F);
  EXPECT_EQ(fused->getResolution(), a->getResolution());
  expectAt(*fused, kBothSimilar, 51.0 / 52);  // odds 9 * 5.67: A's limits, not OctoMap's, hold
}

TEST_F(MergedMaps, WithAnEmptyMapAreTheOther) {
  const OcTree empty(0.1);
  for (const auto policy : kPolicies) {
    EXPECT_EQ(serializeNodes(*mergeMaps(*a, empty, kIdentity, by(policy))), serializeNodes(*a));
    EXPECT_EQ(serializeNodes(*mergeMaps(empty, *b, kIdentity, by(policy))), serializeNodes(*b));
    EXPECT_EQ(mergeMaps(empty, empty, kIdentity, by(policy))->size(), 0);
  }
}

TEST(MergeMaps, PutsTheSceneWhereThePoseSays) {
  const auto a = MapWriter().voxel({0, 0, 0}, logOdds(0.9)).pruned();
  const auto b = MapWriter().voxel({5, 1, 2}, logOdds(0.8)).pruned();
  // A quarter turn takes cell (5, 1) to (-2, 5), and then 3 voxels along x.
  const auto fused = mergeMaps(*a, *b, poseOf(0.3, 0, 0, 90), kRelativeEntropy);
  expectAt(*fused, {0, 0, 0}, 0.9);
  expectAt(*fused, {1, 5, 2}, 0.8);
  EXPECT_EQ(fused->getNumLeafNodes(), 2);
}

TEST(MergeMaps, TakesAPrunedLeafForTheVoxelsItStandsFor) {
  // A: one leaf of 8^3 voxels; B: a few voxels in it, and one beside it.
  MapWriter large;
  large.box({0, 0, 0}, {7, 7, 7}, logOdds(0.9));
  const auto block = large.pruned();
  ASSERT_EQ(block->getNumLeafNodes(), 1);
  const auto few = MapWriter()
                       .voxel({1, 2, 3}, logOdds(0.85))
                       .voxel({7, 7, 7}, logOdds(0.2))
                       .voxel({8, 0, 0}, logOdds(0.7))
                       .pruned();
  const auto expectFused = [](const OcTree& fused) {
    expectAt(fused, {0, 0, 0}, 0.9);
    expectAt(fused, {1, 2, 3}, (0.81 + 0.7225) / 1.75);
    expectAt(fused, {7, 7, 7}, 0.9);
    expectAt(fused, {8, 0, 0}, 0.7);
    EXPECT_FALSE(probabilityAt(fused, {8, 0, 1}));
    EXPECT_EQ(statisticsOf(fused).occupied, 8 * 8 * 8 + 1);
  };
  OcTree expanded(*block);
  expanded.expand();
  for (const auto* model : {&expanded, block.get()}) {
    SCOPED_TRACE(model == &expanded ? "expanded" : "pruned");
    expectFused(*mergeMaps(*model, *few, kIdentity, kRelativeEntropy));
  }
  // The other way round, KL(0.85 || 0.9) is as small and 0.2 against 0.9 as large.
  expectFused(*mergeMaps(*few, *block, kIdentity, kRelativeEntropy));
}

TEST(MergeMaps, IsPruned) {
  // Each holds half of a cube of 4^3 voxels.
  const auto a = MapWriter().box({0, 0, 0}, {1, 3, 3}, 1.F).unpruned();
  const auto b = MapWriter().box({2, 0, 0}, {3, 3, 3}, 1.F).unpruned();
  const auto fused = mergeMaps(*a, *b, kIdentity, kRelativeEntropy);
  EXPECT_EQ(fused->getNumLeafNodes(), 1);
  EXPECT_EQ(statisticsOf(*fused).occupied, 64);
}

TEST(MergeMaps, TakesACoarserScene) {
  const auto a =
      MapWriter(0.1).voxel({0, 0, 0}, logOdds(0.9)).voxel({9, 9, 9}, logOdds(0.3)).pruned();
  const auto b = MapWriter(0.2).voxel({0, 0, 0}, logOdds(0.85)).pruned();
  const auto fused = mergeMaps(*a, *b, kIdentity, kRelativeEntropy);
  EXPECT_EQ(fused->getResolution(), 0.1);
  expectAt(*fused, {0, 0, 0}, (0.81 + 0.7225) / 1.75);
  expectAt(*fused, {1, 1, 1}, 0.85);
  expectAt(*fused, {9, 9, 9}, 0.3);
  EXPECT_FALSE(probabilityAt(*fused, {2, 0, 0}));
  EXPECT_EQ(statisticsOf(*fused).occupied, 8);
}

TEST(MergeMaps, TakesAFinerScene) {
  const auto a = MapWriter(0.1).voxel({5, 5, 5}, logOdds(0.9)).pruned();
  // One of the eight fine voxels of cell (0, 0, 0) is occupied, another free.
  const auto b =
      MapWriter(0.05).voxel({0, 0, 0}, logOdds(0.2)).voxel({1, 1, 0}, logOdds(0.8)).pruned();
  const auto fused = mergeMaps(*a, *b, kIdentity, kRelativeEntropy);
  expectAt(*fused, {0, 0, 0}, 0.8);
  expectAt(*fused, {5, 5, 5}, 0.9);
  EXPECT_EQ(statisticsOf(*fused).occupied, 2);
}

TEST(MergeMaps, OfAMapWithItselfIsThatMap) {
  const auto map = apartment();
  const std::string nodes = serializeNodes(*map);
  for (const auto policy :
       {MergePolicy::RelativeEntropy, MergePolicy::Average, MergePolicy::Stitch})
    EXPECT_TRUE(serializeNodes(*mergeMaps(*map, *map, kIdentity, by(policy))) == nodes)
        << static_cast<int>(policy);
}

TEST(MergeMaps, OfTwoPartsIsTheWhole) {
  // Two robots' parts, 3 m of them in common, in one frame.
  const auto a = apartment({0, 0, 0}, {59, 69, 25}), b = apartment({30, 0, 0}, {99, 69, 25});
  EXPECT_TRUE(serializeNodes(*mergeMaps(*a, *b, kIdentity, kRelativeEntropy)) ==
              serializeNodes(*apartment()));
}

TEST(MergeMaps, HaveTheBitsOfTheirTwin) {
  const double half_pi = 90;
  const std::vector<Eigen::Isometry3d> poses = {
      kIdentity,
      poseOf(0.1, -0.3, 0.2, 0),    // whole voxels
      poseOf(0.05, 0.02, 0.01, 0),  // parts of voxels
      poseOf(1.3, 0.2, -0.4, half_pi),
      poseOf(0.53, -0.71, 0.03, 37, 1.5, -2),
      poseOf(-2.1, 0.4, 0.3, 12, 65, 140),  // nearly upside down
      poseOf(300, 0, 0, 5)                  // no overlap
  };
  unsigned seed = 0;
  for (const auto& T : poses)
    for (const double b_resolution : {0.1, 0.2, 0.06}) {
      const auto a = map_tests::sceneTree(0.1, seed),
                 b = map_tests::sceneTree(b_resolution, ++seed);
      OcTree unpruned(*a);
      if (seed % 3 == 0) unpruned.expand();
      for (const auto policy : kPolicies) {
        SCOPED_TRACE(testing::Message() << seed << " policy " << static_cast<int>(policy));
        const auto expected = map_tests::reference::merged(unpruned, *b, T, by(policy));
        const auto fused = mergeMaps(unpruned, *b, T, by(policy));
        EXPECT_TRUE(serializeNodes(*fused) == serializeNodes(*expected));
        EXPECT_EQ(fused->size(), expected->size());
        EXPECT_EQ(fused->size(), fused->calcNumNodes());
      }
    }
}

}  // namespace
}  // namespace mrpt::fusion::test::merging_test
