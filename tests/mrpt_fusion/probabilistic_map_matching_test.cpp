// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/fusion/poses.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>

#include <Eigen/Eigenvalues>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "fusion_octree/files.h"
#include "support/apartment_pair.h"

namespace mrpt::fusion::test::probabilistic_map_matching_test {
namespace {

using mrpt::config::CConfigFileMemory;
using mrpt::maps::CProbOctoMap;
using mrpt::poses::CPose3D;
using mrpt::poses::CPose3DPDFGaussian;
using mrpt::slam::CProbabilisticMapMatching;
using Options = CProbabilisticMapMatching::TConfigParams;

// ---------------------------------------------------------------- options and .ini files

struct Number {
  std::string key;
  double* field;
  double value;  ///< not the default, in the unit of the .ini file
};
struct Count {
  std::string key;
  unsigned* field;
  unsigned value;
};

struct Size {
  std::string key;
  size_t* field;
  size_t value;
};

/** Numeric parameters of all stages, and a value for each. */
std::vector<Number> numbersOf(Options& o) {
  auto& e = o.features.edges;
  auto& r = o.registration;
  auto& c = r.covariance;
  auto& all = o.search.all_rotations;
  auto& v = o.evaluation;
  return {{"normal_radius", &e.normal_radius, 0.31},
          {"cost_radius", &e.cost_radius, 0.72},
          {"min_normal_radius_voxels", &e.min_normal_radius_voxels, 3.5},
          {"min_cost_radius_voxels", &e.min_cost_radius_voxels, 4.5},
          {"max_surface_variation", &e.max_surface_variation, 0.15},
          {"kappa", &e.kappa, 0.45},
          {"trace_distance", &e.trace_distance, 0.65},
          {"trace_step_deg", &e.trace_step_angle, 12.5},
          {"alpha_min_deg", &e.alpha_min, 77},
          {"alpha_max_deg", &e.alpha_max, 104},
          {"outlier_deviations", &e.outlier_deviations, 2.25},
          {"direction_radius", &e.direction_radius, 0.55},
          {"min_surface_variation", &e.min_surface_variation, 0.05},
          {"trace_window_deg", &e.trace_window, 45},
          {"voxel_spacing", &o.features.voxel_spacing, 0.3},
          {"edge_spacing", &o.features.edge_spacing, 0.5},
          {"search_translation", &o.search.translation, 1.5},
          {"search_height", &o.search.height, 0.4},
          {"search_yaw_deg", &o.search.yaw, 33},
          {"search_cell", &o.search.cell, 0.35},
          {"k1", &r.weights.k1, 0.2},
          {"k2", &r.weights.k2, 3},
          {"edge_gate", &r.edge_level.gate, 1.75},
          {"edge_final_gate", &r.edge_level.final_gate, 1.25},
          {"voxel_gate", &r.voxel_level.gate, 0.6},
          {"voxel_final_gate", &r.voxel_level.final_gate, 0.3},
          {"flatness", &r.flatness, 0.02},
          {"min_step_translation", &r.min_step_translation, 2e-5},
          {"min_step_rotation_deg", &r.min_step_rotation, 0.003},
          {"inlier_mahalanobis", &v.inlier_mahalanobis, 0.25},
          {"max_free_conflict", &v.max_free_conflict, 0.4},
          {"min_overlap", &v.min_overlap, 0.05},
          {"max_runner_up", &v.max_runner_up, 0.6},
          {"min_probability", &v.min_probability, 0.7},
          {"sure_probability", &v.sure_probability, 0.9},
          {"kl_threshold", &o.merge.kl_threshold, 0.123456},
          {"trace_beside_deg", &e.trace_beside, 25},
          {"search_conflict_weight", &o.search.conflict_weight, 7},
          {"search_wall_share", &o.search.wall_share, 0.35},
          {"search_floor_share", &o.search.floor_share, 0.5},
          {"search_margin", &o.search.margin, 4},
          {"search_distinct_yaw_deg", &o.search.distinct_yaw, 12},
          {"search_small_work", &o.search.budget.small_work, 4e7},
          {"search_max_work", &o.search.budget.max_work, 3e9},
          {"search_max_cells", &o.search.budget.max_cells, 5e7},
          {"rotations_alike_deg", &all.alike, 9},
          {"rotations_apart_deg", &all.apart, 21},
          {"rotations_upright_deg", &all.upright, 4},
          {"rotations_min_share", &all.min_share, 0.03},
          {"min_voxel_gate", &r.min_voxel_gate, 2.5},
          {"gate_shrink", &r.gate_shrink, 0.7},
          {"settled_step", &r.settled_step, 0.06},
          {"held_gate", &c.held_gate, 2.5},
          {"held_min_pull", &c.min_pull, 0.2},
          {"covariance_patch", &c.patch_size, 5},
          {"covariance_common_share", &c.common_share, 0.25},
          {"ranking_min_rival_agreement", &o.ranking.min_rival_agreement, 0.1},
          {"ranking_min_step_translation", &o.ranking.min_step_translation, 0.02},
          {"ranking_min_step_rotation_deg", &o.ranking.min_step_rotation, 0.2},
          {"ranking_moved_share", &o.ranking.moved_share, 0.5},
          {"agreement_tolerance", &o.ranking.agreement.tolerance, 0.03},
          {"agreement_other_side", &o.ranking.agreement.other_side, 0.1},
          {"agreement_front_voxels", &o.ranking.agreement.front_voxels, 3},
          {"threshold_without_overlap", &v.threshold_without_overlap, 0.85},
          {"threshold_per_overlap", &v.threshold_per_overlap, 0.4},
          {"min_threshold", &v.min_threshold, 0.55},
          {"max_threshold", &v.max_threshold, 0.75},
          {"min_rival_support", &v.min_rival_support, 0.1},
          {"other_side_rival", &v.other_side_rival, 0.5},
          {"max_size_difference", &v.max_size_difference, 0.03},
          {"held_probability", &v.held_probability, 0.9},
          {"tolerance_translation", &v.tolerance.translation, 0.5},
          {"tolerance_rotation_deg", &v.tolerance.rotation, 5}};
}
std::vector<Count> countsOf(Options& o) {
  return {{"outlier_neighbours", &o.features.edges.outlier_neighbours, 9},
          {"solver_steps", &o.registration.solver.max_steps, 4},
          {"evaluation_voxels", &o.evaluation.voxels, 12345},
          {"search_hypotheses", &o.search.hypotheses, 5},
          {"edge_iterations", &o.registration.edge_level.max_iterations, 17},
          {"voxel_iterations", &o.registration.voxel_level.max_iterations, 23},
          {"ranking_iterations", &o.ranking.max_iterations, 11},
          {"search_distinct_cells", &o.search.distinct_cells, 4},
          {"search_everywhere_hypotheses", &o.search.budget.min_hypotheses_everywhere, 200}};
}
/** The parameters that count what may be many. */
std::vector<Size> sizesOf(Options& o) {
  auto& budget = o.search.budget;
  return {{"search_kept_places", &budget.kept_places, 1000},
          {"search_places_per_yaw", &budget.places_per_yaw, 100},
          {"search_places_per_hypothesis", &budget.places_per_hypothesis, 20},
          {"rotations_surfaces", &o.search.all_rotations.sample_surfaces, 1400},
          {"rotations_directions", &o.search.all_rotations.directions, 3},
          {"first_pairs", &o.registration.first_pairs, 3000},
          {"held_pairs", &o.registration.covariance.sample_pairs, 500},
          {"ranking_few_voxels", &o.ranking.few_voxels, 200},
          {"ranking_many_voxels", &o.ranking.many_voxels, 900},
          {"ranking_max_starts", &o.ranking.max_starts, 20},
          {"ranking_rival_voxels", &o.ranking.rival_voxels, 4000},
          {"ranking_max_rivals", &o.ranking.max_rivals, 3}};
}
const std::set<std::string> kEnumerations = {"search_rotations", "voxel_metric", "voxel_covariance",
                                             "merge_policy"};

double unitOf(const Number& n) {
  const std::string suffix = "_deg";
  const bool in_degrees = n.key.size() > suffix.size() &&
                          n.key.compare(n.key.size() - suffix.size(), suffix.size(), suffix) == 0;
  return in_degrees ? kDegree : 1;
}

std::string iniOf(const Options& o) {
  CConfigFileMemory file;
  o.saveToConfigFile(file, "pmm");
  return file.getContent();
}

void load(Options& o, const std::string& lines) {
  o.loadFromConfigFile(CConfigFileMemory("[pmm]\n" + lines + "\n"), "pmm");
}

TEST(MapMatchingOptions, SavesEachParameterUnderItsKey) {
  Options o;
  std::set<std::string> expected = kEnumerations;
  for (const auto& n : numbersOf(o)) expected.insert(n.key);
  for (const auto& c : countsOf(o)) expected.insert(c.key);
  for (const auto& c : sizesOf(o)) expected.insert(c.key);
  std::vector<std::string> keys;
  CConfigFileMemory(iniOf(o)).getAllKeys("pmm", keys);
  // Keys that a stage adds are in pmm.ini, which ConfigFiles.HoldTheDefaults compares key by key.
  const std::set<std::string> saved(keys.begin(), keys.end());
  EXPECT_TRUE(std::includes(saved.begin(), saved.end(), expected.begin(), expected.end()));
}

TEST(MapMatchingOptions, EachParameterComesBackFromAFile) {
  Options saved;
  for (const auto& n : numbersOf(saved)) {
    ASSERT_NE(*n.field, n.value * unitOf(n)) << n.key << ": choose a value that is not the default";
    *n.field = n.value * unitOf(n);
  }
  for (const auto& c : countsOf(saved)) {
    ASSERT_NE(*c.field, c.value) << c.key;
    *c.field = c.value;
  }
  for (const auto& c : sizesOf(saved)) {
    ASSERT_NE(*c.field, c.value) << c.key;
    *c.field = c.value;
  }
  saved.search.rotations = SearchRotations::All;
  saved.registration.voxel_metric = VoxelMetric::Point;
  saved.registration.voxel_covariance = VoxelCovariance::Quantisation;
  saved.merge.policy = MergePolicy::Average;

  Options loaded;
  loaded.loadFromConfigFile(CConfigFileMemory(iniOf(saved)), "pmm");
  for (const auto& n : numbersOf(loaded)) EXPECT_NEAR(*n.field, n.value * unitOf(n), 1e-9) << n.key;
  for (const auto& c : countsOf(loaded)) EXPECT_EQ(*c.field, c.value) << c.key;
  for (const auto& c : sizesOf(loaded)) EXPECT_EQ(*c.field, c.value) << c.key;
  EXPECT_EQ(loaded.search.rotations, SearchRotations::All);
  EXPECT_EQ(loaded.registration.voxel_metric, VoxelMetric::Point);
  EXPECT_EQ(loaded.registration.voxel_covariance, VoxelCovariance::Quantisation);
  EXPECT_EQ(loaded.merge.policy, MergePolicy::Average);
}

TEST(MapMatchingOptions, DefaultsSurviveAFile) {
  Options defaults, loaded;
  for (const auto& n : numbersOf(loaded)) *n.field = n.value * unitOf(n);
  loaded.loadFromConfigFile(CConfigFileMemory(iniOf(defaults)), "pmm");
  const auto expected = numbersOf(defaults);
  const auto found = numbersOf(loaded);
  for (size_t i = 0; i < expected.size(); i++)
    EXPECT_NEAR(*found[i].field, *expected[i].field, 1e-5 * *expected[i].field) << found[i].key;
}

TEST(MapMatchingOptions, ReadsEachNameOfAnEnumeration) {
  Options o;
  for (const auto& [policy, name] : mergePolicyNames()) {
    load(o, std::string("merge_policy = ") + name);
    EXPECT_EQ(o.merge.policy, policy) << name;
    EXPECT_NE(iniOf(o).find(name), std::string::npos);
  }
  load(o, "search_rotations = all\nvoxel_covariance = quantisation\nvoxel_metric = point");
  EXPECT_EQ(o.search.rotations, SearchRotations::All);
  EXPECT_EQ(o.registration.voxel_covariance, VoxelCovariance::Quantisation);
  EXPECT_EQ(o.registration.voxel_metric, VoxelMetric::Point);
  load(o, "search_rotations = yaw\nvoxel_covariance = plain\nvoxel_metric = surface");
  EXPECT_EQ(o.search.rotations, SearchRotations::Yaw);
  EXPECT_EQ(o.registration.voxel_covariance, VoxelCovariance::Plain);
  EXPECT_EQ(o.registration.voxel_metric, VoxelMetric::Surface);
}

TEST(MapMatchingOptions, MissingKeysKeepTheirValues) {
  Options o;
  o.features.edges.kappa = 0.3;
  o.merge.policy = MergePolicy::Stitch;
  load(o, "alpha_min_deg = 75  // a comment");
  EXPECT_DOUBLE_EQ(o.features.edges.alpha_min, 75 * kDegree);
  EXPECT_EQ(o.features.edges.kappa, 0.3);
  EXPECT_EQ(o.merge.policy, MergePolicy::Stitch);
}

TEST(MapMatchingOptions, RefusesWhatItCannotUseAndStaysAsItWas) {
  Options o;
  o.features.edges.kappa = 0.3;
  const std::string before = iniOf(o);
  for (const char* line : {"kapa = 0.5",
                           "kappa = 1.5",
                           "kappa = -0.1",
                           "kappa = much",
                           "kappa = 0.5 m",
                           "kappa = nan",
                           "kappa = inf",
                           "kappa = 1e999",
                           "kappa =",
                           "kappa_deg = 10",
                           "trace_step_deg = 0",
                           "alpha_max_deg = 181",
                           "outlier_neighbours = 2.5",
                           "outlier_neighbours = 0",
                           "edge_iterations = -1",
                           "min_overlap = 1.01",
                           "voxel_covariance = m2",
                           "merge_policy = best",
                           "merge_policy =",
                           "voxel_metric = plane"}) {
    EXPECT_THROW(load(o, line), std::exception) << line;
    EXPECT_EQ(iniOf(o), before) << line;
  }
  // Nothing of a file is taken if a later line is wrong.
  EXPECT_THROW(load(o, "normal_radius = 0.9\nkappa = 2"), std::exception);
  EXPECT_EQ(iniOf(o), before);
}

TEST(MapMatchingOptions, SaysWhichKeyIsWrongAndWhatItMayBe) {
  Options o;
  try {
    load(o, "kappa = 1.5");
    FAIL();
  } catch (const std::exception& e) {
    const std::string message = e.what();
    EXPECT_NE(message.find("kappa = 1.5"), std::string::npos) << message;
    EXPECT_NE(message.find("[0, 1]"), std::string::npos) << message;
  }
}

// ---------------------------------------------------------------- maps in, pose out

class MapMatching : public testing::Test {
 protected:
  /** A fresh copy as an MRPT map. */
  static CProbOctoMap mapOf(const octomap::OcTree& tree) {
    return CProbOctoMap(std::make_unique<octomap::OcTree>(tree));
  }
  static const ApartmentPair& maps() {
    static const ApartmentPair pair(0.2);
    return pair;
  }
  static CPose3D guessOffBy(double x, double y, double yaw) {
    return toPose(maps().truth * poseOf(x, y, 0, yaw));
  }
  MapMatching() {  // the guesses are near
    pmm.options.search.translation = pmm.options.features.edge_spacing = 0;
  }

  CProbabilisticMapMatching pmm;
  const CProbOctoMap a = mapOf(*maps().map_a), b = mapOf(*maps().map_b);
};

const CPose3DPDFGaussian& gaussian(const mrpt::poses::CPose3DPDF::Ptr& pdf) {
  return dynamic_cast<const CPose3DPDFGaussian&>(*pdf);
}

double leastEigenvalue(const Eigen::MatrixXd& m) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m).eigenvalues()[0];
}

TEST_F(MapMatching, Align3DFindsThePoseOfTheSecondMapInTheFirst) {
  CProbabilisticMapMatching::TReturnInfo info;
  const auto pdf = pmm.Align3D(&a, &b, guessOffBy(0.6, -0.5, 7), info);
  const Eigen::Isometry3d found = toEigen(gaussian(pdf).mean);
  EXPECT_LT(metresBetween(found, maps().truth), 0.1);
  EXPECT_LT(degreesBetween(found, maps().truth), 1);
  EXPECT_TRUE(info.evaluation.accepted);
}

TEST_F(MapMatching, FindsWhatTheCoreFindsAndTellsHow) {
  CProbabilisticMapMatching::TReturnInfo info;
  const CPose3D guess = guessOffBy(0.3, 0.2, -4);
  const auto pdf = pmm.Align3D(&a, &b, guess, info);
  const MatchResult r = matchMaps(maps().a, maps().b, toEigen(guess), pmm.options);
  EXPECT_EQ(info.match.T_a_b.matrix(), r.T_a_b.matrix());
  EXPECT_TRUE(toEigen(gaussian(pdf).mean).isApprox(r.T_a_b, 1e-9));
  EXPECT_EQ(info.match.pairs.size(), r.pairs.size());
  EXPECT_EQ(info.match.iterations.size(), r.iterations.size());
  EXPECT_EQ(info.voxels_a, maps().a.voxels.size());
  EXPECT_EQ(info.voxels_b, maps().b.voxels.size());
  EXPECT_EQ(info.edges_a, maps().a.edges.size());
  EXPECT_EQ(info.edges_b, maps().b.edges.size());
  EXPECT_EQ(info.evaluation.pairs, r.pairs.size());
  EXPECT_EQ(info.evaluation.reasons.size(), 4);
  EXPECT_GT(info.seconds_features, 0);
  EXPECT_GT(info.seconds_matching, 0);
  EXPECT_GT(info.seconds_evaluation, 0);
  EXPECT_GE(info.executionTime, info.seconds_features);
}

TEST_F(MapMatching, CovarianceIsThatOfYawPitchRollAndPositiveDefinite) {
  CProbabilisticMapMatching::TReturnInfo info;
  const auto pdf = pmm.Align3D(&a, &b, guessOffBy(0.3, 0.2, -4), info);
  const Matrix6d cov = gaussian(pdf).cov.asEigen();
  EXPECT_TRUE(
      cov.isApprox(toYawPitchRollCovariance(info.match.covariance, info.match.T_a_b), 1e-9));
  EXPECT_GT(leastEigenvalue(cov), 0);
  EXPECT_LT(cov.diagonal().maxCoeff(), 0.01);  // some centimetres, some tenths of a degree
}

TEST_F(MapMatching, MapsOfAnyKindGiveTheSameAnswer) {
  mrpt::maps::COctoMap octomap_a(0.2), octomap_b(0.2);
  a.toOctoMap(octomap_a);
  b.toOctoMap(octomap_b);
  mrpt::maps::CMultiMetricMap several_a, several_b;
  several_a.maps.push_back(mrpt::maps::CSimplePointsMap::Create());  // not this one
  several_a.maps.push_back(std::make_shared<CProbOctoMap>(a));
  several_b.maps.push_back(std::make_shared<CProbOctoMap>(b));

  const CPose3D guess = guessOffBy(0.3, 0.2, -4);
  const Eigen::Matrix4d expected = toEigen(gaussian(pmm.Align3D(&a, &b, guess)).mean).matrix();
  using MapPair = std::pair<const mrpt::maps::CMetricMap*, const mrpt::maps::CMetricMap*>;
  for (const auto& [m1, m2] : {MapPair{&octomap_a, &octomap_b}, MapPair{&several_a, &several_b},
                               MapPair{&several_a, &octomap_b}}) {
    const Eigen::Matrix4d found = toEigen(gaussian(pmm.Align3D(m1, m2, guess)).mean).matrix();
    EXPECT_EQ(found, expected) << m1->GetRuntimeClass()->className;
  }
}

TEST_F(MapMatching, LeavesItsMapsAsTheyWere) {
  const std::string a_before = mrpt::fusion::serializeNodes(a.octree());
  const std::string b_before = mrpt::fusion::serializeNodes(b.octree());
  pmm.Align3D(&a, &b, guessOffBy(0.3, 0.2, -4));
  EXPECT_TRUE(mrpt::fusion::serializeNodes(a.octree()) == a_before);
  EXPECT_TRUE(mrpt::fusion::serializeNodes(b.octree()) == b_before);
}

TEST_F(MapMatching, AlignPdfIsTheProjectionOnThePlane) {
  using mrpt::poses::CPosePDFGaussian;
  const CPosePDFGaussian guess(mrpt::poses::CPose2D(guessOffBy(0.2, 0.1, 3)),
                               mrpt::math::CMatrixDouble33());
  CProbabilisticMapMatching::TReturnInfo info;
  const auto plane = pmm.AlignPDF(&a, &b, guess, info);
  const auto space = pmm.Align3DPDF(&a, &b, CPose3DPDFGaussian(guess));
  const auto& found = dynamic_cast<const CPosePDFGaussian&>(*plane);
  const auto& expected = gaussian(space);
  EXPECT_NEAR(found.mean.x(), expected.mean.x(), 1e-12);
  EXPECT_NEAR(found.mean.y(), expected.mean.y(), 1e-12);
  EXPECT_NEAR(found.mean.phi(), expected.mean.yaw(), 1e-12);
  const Eigen::Matrix3d cov = found.cov.asEigen();
  const int of_space[] = {0, 1, 3};  // x, y, yaw
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      EXPECT_NEAR(cov(i, j), expected.cov(of_space[i], of_space[j]), 1e-12);
  EXPECT_GT(leastEigenvalue(cov), 0);
  EXPECT_GT(info.match.iterations.size(), 0);
}

TEST(SearchWithin, IsThreeStandardDeviationsOfThePrior) {
  CPose3DPDFGaussian prior;
  SearchParams configured;
  EXPECT_EQ(Prior::gaussian(prior).searchWithin(configured).translation, configured.translation);
  EXPECT_EQ(Prior::gaussian(prior).searchWithin(configured).yaw, configured.yaw);

  // Standard deviations of 2 m along a diagonal, 0.5 m across it.
  prior.cov(0, 0) = prior.cov(1, 1) = 0.5 * (4 + 0.25);
  prior.cov(0, 1) = prior.cov(1, 0) = 0.5 * (4 - 0.25);
  prior.cov(2, 2) = 0.04;
  prior.cov(3, 3) = 0.01;
  const SearchParams search = Prior::gaussian(prior).searchWithin(configured);
  EXPECT_NEAR(search.translation, 6, 1e-9);
  EXPECT_NEAR(search.height, 0.6, 1e-9);
  EXPECT_NEAR(search.yaw, 0.3, 1e-9);
  EXPECT_EQ(search.hypotheses, configured.hypotheses);
  EXPECT_FALSE(search.isEverywhere());

  prior.cov(3, 3) = 100;
  EXPECT_NEAR(Prior::gaussian(prior).searchWithin(configured).yaw, M_PI, 1e-12);
  EXPECT_TRUE(Prior::none().searchWithin(configured).isEverywhere());
  configured.translation = 0;
  EXPECT_EQ(Prior::none().searchWithin(configured).translation, 0) << "no search stays none";
  prior.cov(0, 0) = -1;
  EXPECT_ANY_THROW(Prior::gaussian(prior).searchWithin(configured));
}

TEST_F(MapMatching, APriorBoundsTheSearch) {
  CProbabilisticMapMatching with_search;
  CPose3DPDFGaussian prior(guessOffBy(7, -5, 110));
  const auto errorFrom = [&](const CPose3DPDFGaussian& from) {
    return metresBetween(toEigen(gaussian(with_search.Align3DPDF(&a, &b, from)).mean),
                         maps().truth);
  };
  with_search.options.evaluation.sure_probability = 0;  // no wider search
  EXPECT_GT(errorFrom(prior), 1) << "beyond what is configured";
  prior.cov.setDiagonal(6, 0.04);
  EXPECT_GT(errorFrom(prior), 1) << "beyond what the covariance allows";
  with_search.options = CProbabilisticMapMatching().options;
  EXPECT_GT(errorFrom(prior), 1) << "a wider search stays within the covariance";
  prior.cov.setDiagonal(6, 0);
  EXPECT_LT(errorFrom(prior), 0.1) << "without a covariance the search goes everywhere";
  prior.cov(0, 0) = prior.cov(1, 1) = 16;
  prior.cov(2, 2) = 0.04;
  prior.cov(3, 3) = 0.64;
  EXPECT_LT(errorFrom(prior), 0.1);
}

TEST_F(MapMatching, NeedsNoGuess) {
  CProbabilisticMapMatching with_search;
  CProbabilisticMapMatching::TReturnInfo info;
  const auto pdf = with_search.Align3DPDF(&a, &b, noGuess(), info);
  EXPECT_LT(metresBetween(toEigen(gaussian(pdf).mean), maps().truth), 0.1);
  EXPECT_TRUE(info.evaluation.accepted);
  const mrpt::poses::CPose3DPDFSOG hypotheses = info.hypotheses();
  ASSERT_EQ(hypotheses.size(), info.match.hypotheses.size());
  ASSERT_GE(hypotheses.size(), 2U);
  const auto& best = *hypotheses.begin();
  EXPECT_LT(metresBetween(toEigen(best.val.mean), maps().truth), 0.2);
  EXPECT_GT(leastEigenvalue(best.val.cov.asEigen()), 0);
  EXPECT_NEAR(std::exp((hypotheses.begin() + 1)->log_w - best.log_w), info.evaluation.runner_up,
              1e-9);
}

TEST_F(MapMatching, OfARoomThatIsTheSameTurnedRoundIsAmbiguous) {
  const auto room = MapWriter(0.1)
                        .box({0, 0, 0}, {59, 39, 24}, kFree)
                        .shell({0, 0, 0}, {59, 39, 24}, kOccupied)
                        .box({15, 10, 1}, {18, 13, 15}, kOccupied)
                        .box({41, 26, 1}, {44, 29, 15}, kOccupied)
                        .pruned();
  const CProbOctoMap same = mapOf(*room);
  CProbabilisticMapMatching with_search;
  CProbabilisticMapMatching::TReturnInfo info;
  with_search.Align3DPDF(&same, &same, noGuess(), info);
  EXPECT_TRUE(info.evaluation.is_ambiguous);
  EXPECT_FALSE(info.evaluation.accepted);
  ASSERT_GE(info.match.hypotheses.size(), 2U);
  const auto& [first, second] =
      std::tie(info.match.hypotheses[0].T_a_b, info.match.hypotheses[1].T_a_b);
  EXPECT_NEAR(degreesBetween(first, second), 180, 1);

  // From a guess there is but one.
  with_search.Align3D(&same, &same, CPose3D(0.3, 0.2, 0, 0.1, 0, 0), info);
  EXPECT_FALSE(info.evaluation.is_ambiguous);
  EXPECT_TRUE(info.evaluation.accepted);
}

TEST_F(MapMatching, AWrongGuessIsFoundOutUnlessTheMatchIsSure) {
  const auto room = MapWriter(0.1)
                        .box({0, 0, 0}, {59, 39, 24}, kFree)
                        .shell({0, 0, 0}, {59, 39, 24}, kOccupied)
                        .box({15, 10, 1}, {18, 13, 15}, kOccupied)
                        .box({41, 26, 1}, {44, 29, 15}, kOccupied)
                        .box({41, 10, 1}, {44, 13, 15}, kOccupied)
                        .pruned();
  const CProbOctoMap same = mapOf(*room);
  const CPose3D turned_round(6, 4, 0, M_PI, 0, 0);  // but for one pillar the room is the same
  CProbabilisticMapMatching matching;
  CProbabilisticMapMatching::TReturnInfo info;
  matching.options.evaluation.sure_probability = 0;
  matching.Align3D(&same, &same, turned_round, info);
  ASSERT_TRUE(info.evaluation.accepted);
  const double stated = info.evaluation.probability;

  matching.options.evaluation.sure_probability = stated;  // sure enough
  matching.Align3D(&same, &same, turned_round, info);
  EXPECT_TRUE(info.evaluation.accepted);

  matching.options.evaluation.sure_probability = 1;
  matching.Align3D(&same, &same, turned_round, info);
  // The better pose elsewhere is the result, and the match near the guess is its rival.
  EXPECT_TRUE(info.evaluation.accepted);
  EXPECT_LT(metresBetween(info.match.T_a_b, Eigen::Isometry3d::Identity()), 0.05);
  ASSERT_GE(info.match.hypotheses.size(), 2U);
  EXPECT_NEAR(degreesBetween(info.match.hypotheses[1].T_a_b, toEigen(turned_round)), 0, 1);

  // Rejected if the pose elsewhere does not pass the test of rivals.
  matching.options.evaluation.min_probability = 1;
  matching.options.evaluation.sure_probability = 0.999;
  matching.Align3D(&same, &same, turned_round, info);
  EXPECT_FALSE(info.evaluation.accepted);
  matching.options = CProbabilisticMapMatching().options;
  matching.options.evaluation.sure_probability = 1;

  const auto judged = matching.evaluate(same, same, turned_round);
  EXPECT_TRUE(judged.evaluation.is_ambiguous);
  EXPECT_TRUE(matching.evaluate(same, same, CPose3D()).evaluation.accepted);

  matching.Align3D(&same, &same, CPose3D(0.3, 0.2, 0, 0.1, 0, 0), info);
  EXPECT_TRUE(info.evaluation.accepted) << "the same search finds nothing better";
}

TEST_F(MapMatching, WorksThroughItsBaseClass) {
  auto ours = std::make_shared<CProbabilisticMapMatching>();
  ours->options = pmm.options;
  const std::shared_ptr<mrpt::slam::CMetricMapsAlignmentAlgorithm> algorithm = ours;
  const CPose3D guess = guessOffBy(0.3, 0.2, -4);
  const auto pdf = algorithm->Align3D(&a, &b, guess);
  EXPECT_LT(metresBetween(toEigen(gaussian(pdf).mean), maps().truth), 0.1);
  EXPECT_EQ(toEigen(pdf->getMeanVal()).matrix(),
            toEigen(gaussian(pmm.Align3D(&a, &b, guess)).mean).matrix());
  const auto plane = algorithm->Align(&a, &b, mrpt::poses::CPose2D(guess));
  EXPECT_LT(plane->getMeanVal().distanceTo(mrpt::poses::CPose2D(toPose(maps().truth))), 0.15);
}

TEST_F(MapMatching, TellsThePlainResultOfTheBaseClassItsTime) {
  mrpt::slam::TMetricMapAlignmentResult plain;
  plain.executionTime = -1;
  pmm.Align3D(&a, &b, guessOffBy(0, 0, 0), plain);
  EXPECT_GT(plain.executionTime, 0);
}

TEST_F(MapMatching, CallsBackAtEachIteration) {
  size_t calls = 0;
  pmm.onIteration = [&](const IterationRecord&) { calls++; };
  CProbabilisticMapMatching::TReturnInfo info;
  pmm.Align3D(&a, &b, guessOffBy(0.3, 0.2, -4), info);
  EXPECT_GT(calls, 2);
  EXPECT_EQ(calls, info.match.iterations.size());
}

TEST_F(MapMatching, RefusesMapsThatItCannotMatch) {
  const CProbOctoMap empty(0.1);
  CProbOctoMap only_free(0.1);
  only_free.updateVoxel(0, 0, 0, false);
  const mrpt::maps::CSimplePointsMap points;
  const mrpt::maps::CMultiMetricMap nothing;
  for (const mrpt::maps::CMetricMap* bad : std::initializer_list<const mrpt::maps::CMetricMap*>{
           nullptr, &empty, &only_free, &points, &nothing}) {
    EXPECT_THROW(pmm.Align3D(&a, bad, CPose3D()), std::exception);
    EXPECT_THROW(pmm.Align3D(bad, &b, CPose3D()), std::exception);
    EXPECT_THROW(pmm.Align(bad, &b, mrpt::poses::CPose2D()), std::exception);
  }
  EXPECT_THROW(pmm.edges(points), std::exception);
  EXPECT_THROW(pmm.evaluate(a, points, CPose3D()), std::exception);
  EXPECT_THROW(pmm.merge(points, b, CPose3D()), std::exception);
}

// ---------------------------------------------------------------- single steps

TEST_F(MapMatching, EdgesAreThoseOfTheCore) {
  EXPECT_EQ(pmm.edges(a).centre, maps().a.edges.centre);
  pmm.options.features.edges.kappa = 0.9;
  EXPECT_LT(pmm.edges(a).size(), maps().a.edges.size());
}

TEST_F(MapMatching, EvaluateJudgesAsAlignDoes) {
  CProbabilisticMapMatching::TReturnInfo aligned;
  const auto pdf = pmm.Align3D(&a, &b, guessOffBy(0.3, 0.2, -4), aligned);
  const auto info = pmm.evaluate(a, b, gaussian(pdf).mean);
  EXPECT_TRUE(info.evaluation.accepted);
  EXPECT_NEAR(info.evaluation.inlier_ratio, aligned.evaluation.inlier_ratio, 1e-3);
  EXPECT_NEAR(info.evaluation.overlap, aligned.evaluation.overlap, 1e-3);
  EXPECT_NEAR(info.evaluation.free_space.conflictRatio(),
              aligned.evaluation.free_space.conflictRatio(), 1e-3);
  EXPECT_EQ(info.match.pairs.size(), info.evaluation.pairs);
  EXPECT_EQ(info.voxels_a, maps().a.voxels.size());
  EXPECT_FALSE(pmm.evaluate(a, b, guessOffBy(1, 0, 0)).evaluation.accepted);
  EXPECT_FALSE(pmm.evaluate(a, b, guessOffBy(100, 0, 0)).evaluation.accepted);
}

TEST_F(MapMatching, MergeIsThatOfTheCoreByItsPolicy) {
  const CPose3D pose = toPose(maps().truth);
  for (const auto policy : {MergePolicy::RelativeEntropy, MergePolicy::Bayes}) {
    pmm.options.merge.policy = policy;
    const CProbOctoMap fused = pmm.merge(a, b, pose);
    const auto expected = mergeMaps(a.octree(), b.octree(), toEigen(pose), pmm.options.merge);
    EXPECT_TRUE(mrpt::fusion::serializeNodes(fused.octree()) ==
                mrpt::fusion::serializeNodes(*expected));
    EXPECT_GT(fused.octree().getNumLeafNodes(), a.octree().getNumLeafNodes());
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::probabilistic_map_matching_test
