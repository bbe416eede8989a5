// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/registration/association.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <stdexcept>
#include <utility>

#include "fusion_core/map/voxel_blocks.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::association_test {
namespace {

/** A perfect line's covariance. */
EdgeCovariance alongLine(const Eigen::Vector3d& tau) {
  EdgeCovariance c;
  c.eigenvalues << 0, 0, 0.1;
  c.eigenvectors.col(2) = tau.normalized();
  c.eigenvectors.col(0) = c.eigenvectors.col(2).unitOrthogonal();
  c.eigenvectors.col(1) = c.eigenvectors.col(2).cross(c.eigenvectors.col(0));
  return c;
}

void add(EdgeVoxels& edges, const Eigen::Vector3d& centre, float probability,
         const Eigen::Vector3d& tau) {
  edges.centre.push_back(centre.cast<float>());
  edges.probability.push_back(probability);
  edges.covariance.push_back(alongLine(tau));
}

// ---------------------------------------------------------------- eqs. (15), (16), (18)-(20)

TEST(OccupancyUncertainty, ByHand) {
  // -p ln p: 0.5 ln 2, 0, 0.25 ln 4
  EXPECT_NEAR(occupancyUncertainty({0.5F, 1.F}, {0.25F}), std::log(2.0) / 3, 1e-7);
  EXPECT_NEAR(occupancyUncertainty({static_cast<float>(std::exp(-1.0))}, {}), std::exp(-1.0), 1e-7);
}

TEST(OccupancyUncertainty, IsZeroOfCertainVoxelsAndOfNone) {
  EXPECT_EQ(occupancyUncertainty({1.F, 1.F}, {1.F, 0.F}), 0);
  EXPECT_EQ(occupancyUncertainty({}, {}), 0);
}

TEST(StructuralUncertainty, ByHand) {
  EdgeVoxels model, scene;
  add(model, {0, 0, 0}, 0.9F, {1, 0, 0});  // perfect: 1
  add(model, {0, 0, 0}, 0.9F, {1, 0, 0});
  model.covariance[1].eigenvalues << 1, 2, 5;  // 5/8
  add(scene, {0, 0, 0}, 0.9F, {1, 0, 0});
  scene.covariance[0].eigenvalues << 2, 2, 2;  // 1/3
  EXPECT_NEAR(structuralUncertainty(model, scene), (1 + 5.0 / 8 + 1.0 / 3) / 3, 1e-12);
  EXPECT_EQ(structuralUncertainty(EdgeVoxels(), EdgeVoxels()), 0);
}

TEST(MeanSquaredError, ByHand) {
  EXPECT_DOUBLE_EQ(meanSquaredError({{0, 0, 0.25F}, {1, 1, 1.F}, {2, 5, 0.F}}), 1.25 / 3);
  EXPECT_EQ(meanSquaredError({}), 0);
}

TEST(DescriptorWeights, ByHand) {
  WeightParams params;
  params.k1 = 0.3;
  params.k2 = 2;
  const DescriptorWeights w = descriptorWeights(0.04, 0.2, 0.9, params);
  EXPECT_DOUBLE_EQ(w.omega_o, 0.3 * 0.04 / 0.2);
  EXPECT_DOUBLE_EQ(w.omega_tau, 2 * 0.04 * 0.9);
  EXPECT_EQ(descriptorWeights(0.04, 0.2, 0, params).omega_tau, 0);
  EXPECT_EQ(descriptorWeights(0, 0.2, 0.9, params).omega_o, 0);
}

TEST(DescriptorWeights, StayFiniteWhenAllVoxelsAreCertain) {
  WeightParams params;
  params.k1 = 0.3;
  EXPECT_DOUBLE_EQ(descriptorWeights(0.04, 0, 0.9, params).omega_o, 0.3 * 0.04 / 1e-3);
  EXPECT_EQ(descriptorWeights(0, 0, 0.9, params).omega_o, 0);
}

// ---------------------------------------------------------------- eqs. (13), (14): brute force

/** Eq. (13)'s distance, and eq. (14)'s where there are no directions. */
using Distance = std::function<double(size_t model, size_t scene)>;

/** The nearest model voxel of each scene voxel, and by how much the next one, or the gate, is
 * farther: where that is less than single precision can tell, either answer is right. */
struct Twin {
  std::optional<size_t> a;
  double margin = std::numeric_limits<double>::max();
};

Twin nearest(size_t model_size, size_t scene, double gate, const Distance& distance) {
  std::vector<std::pair<double, size_t>> all;
  for (size_t m = 0; m < model_size; m++) all.emplace_back(distance(m, scene), m);
  std::sort(all.begin(), all.end());
  Twin twin;
  twin.margin = std::abs(all[0].first - gate * gate);
  if (all[0].first < gate * gate) {
    twin.a = all[0].second;
    twin.margin = std::min(twin.margin, all[1].first - all[0].first);
  }
  return twin;
}

/** The pairs are those of the twin, in the scene's order, with their Euclidean distances. */
template <class Voxels>
void expectPairsOfTwin(const Pairs& pairs, const Voxels& model, const Voxels& scene,
                       const Eigen::Isometry3d& T, double gate, const Distance& distance) {
  ASSERT_TRUE(std::is_sorted(pairs.begin(), pairs.end(),
                             [](const Pair& a, const Pair& b) { return a.b < b.b; }));
  std::map<size_t, Pair> of_scene;
  for (const Pair& p : pairs) of_scene[p.b] = p;
  ASSERT_EQ(of_scene.size(), pairs.size());

  size_t paired = 0, unpaired = 0;
  for (size_t s = 0; s < scene.size(); s++) {
    const Twin twin = nearest(model.size(), s, gate, distance);
    if (twin.margin < 1e-5) continue;
    const auto found = of_scene.find(s);
    ASSERT_EQ(found != of_scene.end(), twin.a.has_value()) << s;
    (twin.a ? paired : unpaired)++;
    if (!twin.a) continue;
    ASSERT_EQ(found->second.a, *twin.a) << s;
    const Eigen::Vector3d e =
        model.centre[*twin.a].template cast<double>() - T * scene.centre[s].template cast<double>();
    ASSERT_NEAR(found->second.squared_distance, e.squaredNorm(), 1e-5) << s;
  }
  EXPECT_GT(paired, scene.size() / 4);
  EXPECT_GT(unpaired, scene.size() / 20);
}

class Association : public testing::Test {
 protected:
  Eigen::Vector3d randomVector(double scale) {
    std::uniform_real_distribution<double> u(-scale, scale);
    return {u(random), u(random), u(random)};
  }
  float randomProbability() { return std::uniform_real_distribution<float>(0.5F, 1.F)(random); }

  OccupiedVoxels randomVoxels(size_t n) {
    OccupiedVoxels v;
    v.resolution = 0.1;
    for (size_t i = 0; i < n; i++) {
      v.centre.push_back(randomVector(3).cast<float>());
      v.probability.push_back(randomProbability());
    }
    return v;
  }
  EdgeVoxels randomEdges(size_t n) {
    EdgeVoxels e;
    e.resolution = 0.1;
    for (size_t i = 0; i < n; i++) add(e, randomVector(3), randomProbability(), randomVector(1));
    return e;
  }

  std::mt19937 random{7};
  const Eigen::Isometry3d T = poseOf(0.8, -0.3, 0.2, 50, 10, -20);
};

TEST_F(Association, OfVoxelsIsThatOfBruteForce) {
  const OccupiedVoxels model = randomVoxels(700), scene = randomVoxels(500);
  VoxelAssociation association(model);
  // One object, weighted anew each time.
  for (const double omega_o : {0.0, 0.5, 8.0, 0.1}) {
    const double gate = 0.5;
    SCOPED_TRACE(omega_o);
    expectPairsOfTwin(association.associate(scene, T, {omega_o, 0}, gate), model, scene, T, gate,
                      [&](size_t m, size_t s) {
                        const double p = model.probability[m] - scene.probability[s];
                        return (model.centre[m].cast<double>() - T * scene.centre[s].cast<double>())
                                   .squaredNorm() +
                               omega_o * p * p;
                      });
  }
}

TEST_F(Association, OfAnOctreesVoxelsIsTheSameWithTheirBlocks) {
  octomap::OcTree map(0.1);
  std::uniform_int_distribution<int> key(32740, 32790);
  std::uniform_real_distribution<float> log_odds(0.1F, 3);
  const auto some = [&] { return static_cast<octomap::key_type>(key(random)); };
  for (int i = 0; i < 4000; i++)
    map.setNodeValue(octomap::OcTreeKey(some(), some(), some()), log_odds(random), true);
  map.updateInnerOccupancy();
  const OccupiedVoxels model = extractOccupiedVoxels(map), scene = randomVoxels(500);
  const VoxelBlocks blocks(model.key);
  for (const double gate : {0.2, 0.5, 2.0}) {  // the last on a coarser grid
    const Pairs expected = VoxelAssociation(model).associate(scene, T, {0.1, 0}, gate);
    const Pairs pairs = VoxelAssociation(model, blocks).associate(scene, T, {0.1, 0}, gate);
    ASSERT_GT(pairs.size(), 100U) << gate;
    ASSERT_EQ(pairs.size(), expected.size()) << gate;
    for (size_t i = 0; i < pairs.size(); i++) {
      EXPECT_EQ(pairs[i].a, expected[i].a) << gate;
      EXPECT_EQ(pairs[i].b, expected[i].b) << gate;
    }
  }
}

TEST_F(Association, OfEdgesIsThatOfBruteForceWhateverTheSignOfTheirDirections) {
  const EdgeVoxels model = randomEdges(700), scene = randomEdges(500);
  EdgeAssociation association(model);
  for (const auto& w : {DescriptorWeights{0, 0}, {0.3, 0}, {0, 0.2}, {1.0, 0.1}}) {
    const double gate = 0.6;
    SCOPED_TRACE(testing::Message() << w.omega_o << " " << w.omega_tau);
    expectPairsOfTwin(association.associate(scene, T, w, gate), model, scene, T, gate,
                      [&](size_t m, size_t s) {
                        const double p = model.probability[m] - scene.probability[s];
                        const Eigen::Vector3d a = model.covariance[m].direction();
                        const Eigen::Vector3d b = T.linear() * scene.covariance[s].direction();
                        return (model.centre[m].cast<double>() - T * scene.centre[s].cast<double>())
                                   .squaredNorm() +
                               w.omega_o * p * p +
                               w.omega_tau * std::min((a - b).squaredNorm(), (a + b).squaredNorm());
                      });
  }
}

TEST_F(Association, DoesNotDependOnTheSignOfAnyDirection) {
  const EdgeVoxels model = randomEdges(300), scene = randomEdges(300);
  const auto someFlipped = [this](EdgeVoxels edges) {
    for (auto& c : edges.covariance)
      if (random() % 2) c.eigenvectors.col(2) *= -1;
    return edges;
  };
  const auto pairsOf = [this](const EdgeVoxels& m, const EdgeVoxels& s) {
    std::vector<std::pair<uint32_t, uint32_t>> indices;
    for (const Pair& p : EdgeAssociation(m).associate(s, T, {0.1, 0.2}, 0.8))
      indices.emplace_back(p.a, p.b);
    return indices;
  };
  const auto expected = pairsOf(model, scene);
  ASSERT_GT(expected.size(), 100);
  EXPECT_EQ(pairsOf(model, someFlipped(scene)), expected);
  EXPECT_EQ(pairsOf(someFlipped(model), scene), expected);
}

TEST_F(Association, GateIsInMetresOnTheWholeDescriptor) {
  OccupiedVoxels model, scene;
  model.centre = {{0, 0, 0}};
  model.probability = {0.5F};
  scene.centre = {{0.3F, 0, 0}};
  scene.probability = {1.F};
  VoxelAssociation association(model);
  const auto found = [&](double omega_o, double gate) {
    return association.associate(scene, Eigen::Isometry3d::Identity(), {omega_o, 0}, gate).size();
  };
  EXPECT_EQ(found(0, 0.301), 1);
  EXPECT_EQ(found(0, 0.299), 0);
  // 0.3^2 + 0.64 * 0.5^2 = 0.5^2
  EXPECT_EQ(found(0.64, 0.501), 1);
  EXPECT_EQ(found(0.64, 0.499), 0);
}

TEST_F(Association, EqualDistancesGoToTheLowerIndex) {
  // On a grid, in the middle of cells: eight voxels are nearest. Which one is taken must not depend
  // on the order in which cells are looked through.
  OccupiedVoxels model, scene;
  for (int x = 0; x < 12; x++)
    for (int y = 0; y < 12; y++)
      for (int z = 0; z < 12; z++) {
        model.centre.emplace_back(x, y, z);
        model.probability.push_back(0.5F);
        scene.centre.emplace_back(x + 0.5F, y + 0.5F, z + 0.5F);
        scene.probability.push_back(0.5F);
      }
  const Pairs pairs =
      VoxelAssociation(model).associate(scene, Eigen::Isometry3d::Identity(), {}, 0.9);
  ASSERT_EQ(pairs.size(), scene.size());
  EXPECT_EQ(std::count_if(pairs.begin(), pairs.end(), [](const Pair& p) { return p.a != p.b; }), 0);
}

TEST_F(Association, WithAnEmptySetPairsNothing) {
  EXPECT_TRUE(VoxelAssociation(OccupiedVoxels()).associate(randomVoxels(5), T, {}, 100).empty());
  EXPECT_TRUE(VoxelAssociation(randomVoxels(5)).associate(OccupiedVoxels(), T, {}, 100).empty());
  EXPECT_TRUE(EdgeAssociation(EdgeVoxels()).associate(randomEdges(5), T, {}, 100).empty());
  EXPECT_TRUE(EdgeAssociation(randomEdges(5)).associate(EdgeVoxels(), T, {}, 100).empty());
}

TEST_F(Association, IsTheSameForAnyNumberOfThreads) {
  const EdgeVoxels model = randomEdges(3000), scene = randomEdges(3000);
  const auto associate = [&] { return EdgeAssociation(model).associate(scene, T, {0.1, 0.2}, 1); };
  const Pairs one = withThreads(1, associate), two = withThreads(2, associate);
  ASSERT_GT(one.size(), 1000);
  ASSERT_EQ(one.size(), two.size());
  for (size_t i = 0; i < one.size(); i++) {
    ASSERT_EQ(one[i].a, two[i].a);
    ASSERT_EQ(one[i].b, two[i].b);
    ASSERT_EQ(one[i].squared_distance, two[i].squared_distance);
  }
}

// ---------------------------------------------------------------- the paper's Fig. 8

/** Two arms of 2 m from a corner, along x and along y. */
EdgeVoxels lShape(const Eigen::Vector3d& corner) {
  EdgeVoxels l;
  l.resolution = 0.1;
  for (int i = 1; i <= 20; i++)
    add(l, corner + 0.1 * i * Eigen::Vector3d::UnitX(), 0.9F, {1, 0, 0});
  for (int i = 1; i <= 20; i++)
    add(l, corner + 0.1 * i * Eigen::Vector3d::UnitY(), 0.9F, {0, 1, 0});
  return l;
}

/** Scene voxels that found a voxel of the other arm. */
size_t onTheWrongArm(const Pairs& pairs) {
  return std::count_if(pairs.begin(), pairs.end(),
                       [](const Pair& p) { return (p.a < 20) != (p.b < 20); });
}

TEST_F(Association, DirectionsKeepTheArmsOfAnLApartWhereDistanceMixesThem) {
  const EdgeVoxels model = lShape({0, 0, 0}), scene = lShape({0.25, 0.37, 0});
  const auto identity = Eigen::Isometry3d::Identity();
  EdgeAssociation association(model);
  const Pairs by_distance = association.associate(scene, identity, {}, 2);
  EXPECT_EQ(by_distance.size(), scene.size());
  EXPECT_GT(onTheWrongArm(by_distance), 0);

  const DescriptorWeights weights = descriptorWeights(
      meanSquaredError(by_distance), occupancyUncertainty(model.probability, scene.probability),
      structuralUncertainty(model, scene), WeightParams());
  const Pairs by_descriptor = association.associate(scene, identity, weights, 2);
  EXPECT_EQ(by_descriptor.size(), scene.size());
  EXPECT_EQ(onTheWrongArm(by_descriptor), 0);
}

TEST_F(Association, OccupancyTellsApartVoxelsThatDistanceMixes) {
  OccupiedVoxels model, scene;
  model.centre = {{0, 0, 0}, {0.3F, 0, 0}};  // a wall, and its blurred double
  model.probability = {0.95F, 0.55F};
  scene.centre = {{0.16F, 0, 0}};
  scene.probability = {0.95F};
  VoxelAssociation association(model);
  const auto partner = [&](double omega_o) {
    return association.associate(scene, Eigen::Isometry3d::Identity(), {omega_o, 0}, 2).at(0).a;
  };
  EXPECT_EQ(partner(0), 1);
  EXPECT_EQ(partner(0.1), 0);
}

// Several threads share an association: none may make it ready for a wider gate under the others.
TEST_F(Association, IsSharedForTheGatesItIsPreparedFor) {
  OccupiedVoxels voxels;
  voxels.resolution = 0.2;
  voxels.centre = {{0.1F, 0.1F, 0.1F}};
  voxels.probability = {0.9F};
  VoxelAssociation association(voxels);
  const auto shared = [&](double gate) {
    return std::as_const(association)
        .associate(voxels, Eigen::Isometry3d::Identity(), {}, gate)
        .size();
  };
  EXPECT_THROW(shared(0.1), std::logic_error);
  association.prepare(0.5);
  EXPECT_EQ(shared(0.5), 1U);
  EXPECT_THROW(shared(0.6), std::logic_error);
  association.prepare(0.6);
  association.prepare(0.1);
  EXPECT_EQ(shared(0.6), 1U);
}

}  // namespace
}  // namespace mrpt::fusion::test::association_test
