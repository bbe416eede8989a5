// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/fusion/poses.h>
#include <mrpt/math/wrap2pi.h>

#include <Eigen/Geometry>
#include <functional>
#include <random>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/features/uncertainty.h"
#include "fusion_core/map/eigen_solvers.h"
#include "fusion_core/registration/pose_covariance.h"
#include "fusion_core/registration/residuals.h"
#include "fusion_core/registration/solver.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::optimization_test {
namespace {

/** Random voxels and edge voxels of a scene and of the model that it is to be brought onto, paired
 * index by index. */
class Optimization : public testing::Test {
 protected:
  double normal() { return std::normal_distribution<double>()(random); }
  Eigen::Vector3d normalVector() { return {normal(), normal(), normal()}; }
  float probability() { return std::uniform_real_distribution<float>(0.5F, 1.F)(random); }

  EdgeCovariance randomCovariance() {
    std::vector<Eigen::Vector3f> points(6);
    for (auto& p : points)
      p = (0.3 * normalVector().cwiseProduct(Eigen::Vector3d(1, 0.2, 0.5))).cast<float>();
    return edgeCovariance(points);
  }

  /** A pair: the scene's point, and the model's at T_a_b * point + offset. */
  void addPair(const Eigen::Vector3d& point,
               const Eigen::Vector3d& offset = Eigen::Vector3d::Zero()) {
    const auto i = static_cast<uint32_t>(pairs.size());
    pairs.push_back({i, i, 0});
    for (auto* set : {&scene, &model}) {
      set->resolution = edges(*set).resolution = 0.1;
      set->probability.push_back(probability());
      edges(*set).probability.push_back(set->probability.back());
      edges(*set).covariance.push_back(randomCovariance());
    }
    const Eigen::Vector3f s = point.cast<float>();
    const Eigen::Vector3f m = (T_a_b * s.cast<double>() + offset).cast<float>();
    for (auto* normals : {&model_normals, &scene_normals})
      normals->push_back(normalVector().normalized().cast<float>());
    scene.centre.push_back(s);
    scene_edges.centre.push_back(s);
    model.centre.push_back(m);
    model_edges.centre.push_back(m);
  }
  void addPairs(int n, double noise) {
    for (int i = 0; i < n; i++) addPair(5 * normalVector(), noise * normalVector());
  }

  NormalEquations voxelsAt(const Eigen::Isometry3d& T) const {
    return linearizeVoxels(model, scene, pairs, T);
  }
  NormalEquations surfacesAt(const Eigen::Isometry3d& T, double flatness = 0.05) const {
    return linearizeSurfaces(surfacesOf(model, model_normals), surfacesOf(scene, scene_normals),
                             pairs, T, flatness);
  }
  static SurfaceVoxels surfacesOf(const OccupiedVoxels& voxels,
                                  const std::vector<Eigen::Vector3f>& normals) {
    return {voxels, {normals, voxels.centre, {}, std::vector<float>(voxels.size(), 1)}};
  }
  NormalEquations edgesAt(const Eigen::Isometry3d& T,
                          VoxelCovariance kind = VoxelCovariance::Quantisation) const {
    return linearizeEdges(model_edges, scene_edges, pairs, T, kind);
  }
  Eigen::Isometry3d optimizeVoxels(const Eigen::Isometry3d& T, SolverParams params = {}) const {
    return optimizePose(
        T, params, [&](const auto& at) { return voxelsAt(at); },
        [&](const auto& at) { return voxelError(model, scene, pairs, at); });
  }
  Eigen::Isometry3d optimizeEdges(const Eigen::Isometry3d& T, SolverParams params = {}) const {
    return optimizePose(
        T, params, [&](const auto& at) { return edgesAt(at); },
        [&](const auto& at) {
          return edgeError(model_edges, scene_edges, pairs, at, VoxelCovariance::Quantisation);
        });
  }

  std::mt19937 random{11};
  Eigen::Isometry3d T_a_b = poseOf(3, -2, 0.5, 40, -15, 25);
  OccupiedVoxels model, scene;
  EdgeVoxels model_edges, scene_edges;
  std::vector<Eigen::Vector3f> model_normals, scene_normals;
  Pairs pairs;

 private:
  EdgeVoxels& edges(const OccupiedVoxels& of) { return &of == &model ? model_edges : scene_edges; }
};

using ErrorAt = std::function<double(const Eigen::Isometry3d&)>;

/** An error whose weights are held at T, as one linearisation sees it. */
template <class Linearize>
ErrorAt withWeightsHeldAt(const Eigen::Isometry3d& T, const Pairs& pairs,
                          const std::vector<Eigen::Vector3f>& model,
                          const std::vector<Eigen::Vector3f>& scene, Linearize&& linearize) {
  std::vector<Eigen::Matrix3d> W;
  for (const Pair& p : pairs) W.push_back(linearize(Pairs{p}, T).H.template topLeftCorner<3, 3>());
  return [=](const Eigen::Isometry3d& at) {
    double error = 0;
    for (size_t i = 0; i < pairs.size(); i++) {
      const Eigen::Vector3d e =
          model[pairs[i].a].cast<double>() - at * scene[pairs[i].b].cast<double>();
      error += e.dot(W[i] * e);
    }
    return error;
  };
}

Vector6d unit(int i, double length) { return length * Vector6d::Unit(i); }

/** Derivatives of an error by xi at T, by central differences. */
Vector6d numericGradient(const ErrorAt& error, const Eigen::Isometry3d& T,
                         const Eigen::Vector3d& centre) {
  constexpr double h = 1e-5;
  Vector6d g;
  for (int i = 0; i < 6; i++)
    g[i] =
        (error(perturb(T, unit(i, h), centre)) - error(perturb(T, unit(i, -h), centre))) / (2 * h);
  return g;
}
Matrix6d numericHessian(const ErrorAt& error, const Eigen::Isometry3d& T,
                        const Eigen::Vector3d& centre) {
  constexpr double h = 1e-3;
  Matrix6d H;
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++) {
      const auto at = [&](double a, double b) {
        return error(perturb(T, unit(i, a) + unit(j, b), centre));
      };
      H(i, j) = (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h)) / (4 * h * h);
    }
  return H;
}

// ---------------------------------------------------------------- eqs. (21), (22), surfaces

TEST_F(Optimization, EquationsAboutAnotherCentreTellTheSameOfTheSameMotion) {
  addPair({1, 2, 3}, {0.1, 0, 0});
  addPair({0, -4, 1}, {0, 0.3, 0.4});
  addPair({2, 0, -1}, {-0.2, 0.1, 0});
  const NormalEquations n = voxelsAt(T_a_b), moved = n.about({7, -3, 2});
  EXPECT_EQ(moved.centre, Eigen::Vector3d(7, -3, 2));
  const auto errorAfter = [](const NormalEquations& e, const Vector6d& xi) {
    return e.error - 2 * e.g.dot(xi) + xi.dot(e.H * xi);
  };
  for (const Vector6d& about_moved :
       {unit(0, 0.1), unit(3, 0.2), unit(5, -0.1), Vector6d(Vector6d::Constant(0.05))}) {
    Vector6d xi = about_moved;  // turning about the other centre shifts this one
    xi.head<3>() += about_moved.tail<3>().cross(n.centre - moved.centre);
    EXPECT_NEAR(errorAfter(moved, about_moved), errorAfter(n, xi), 1e-9);
  }
}

TEST_F(Optimization, VoxelErrorIsEq22) {
  addPair({1, 2, 3}, {0.1, 0, 0});
  addPair({0, 0, 1}, {0, 0.3, 0.4});
  model.probability = {0.5F, 1.F};
  scene.probability = {0.5F, 0.25F};
  // 0.01 / (2 + 2) + 0.25 / (1 + 4)
  EXPECT_NEAR(voxelsAt(T_a_b).error, 0.0025 + 0.05, 1e-6);
}

TEST_F(Optimization, EdgeErrorIsEq21) {
  for (const auto kind : {VoxelCovariance::Plain, VoxelCovariance::Quantisation}) {
    addPairs(5, 0.2);
    const Eigen::Isometry3d T = poseOf(0.1, 0, 0.05, 3, 2, 1) * T_a_b;
    // Textbook: explicit inverses; where the neighbours do not spread, the voxels' own extent.
    const auto fused = [&](const EdgeVoxels& e, uint32_t i) -> Eigen::Matrix3d {
      const double unit = kind == VoxelCovariance::Plain ? 1 : 0.01 / 12;
      const Eigen::Matrix3d sigma_p = unit / e.probability[i] * Eigen::Matrix3d::Identity();
      const Eigen::Matrix3d sigma_tau = e.covariance[i].matrix(0.01 / 12);
      return (sigma_p.inverse() + sigma_tau.inverse()).inverse();
    };
    double expected = 0;
    for (const Pair& p : pairs) {
      const Eigen::Vector3d e =
          model_edges.centre[p.a].cast<double>() - T * scene_edges.centre[p.b].cast<double>();
      const Eigen::Matrix3d in_a = T.linear() * fused(scene_edges, p.b) * T.linear().transpose();
      expected += e.dot((fused(model_edges, p.a) + in_a).inverse() * e);
    }
    EXPECT_NEAR(edgesAt(T, kind).error, expected, 1e-6 * expected);
  }
}

TEST_F(Optimization, VoxelGradientIsThatOfTheError) {
  addPairs(20, 0.3);
  const Eigen::Isometry3d T = poseOf(0.3, 0.1, -0.2, 5, 4, -3) * T_a_b;
  const auto error = [&](const auto& at) { return voxelsAt(at).error; };
  EXPECT_TRUE((-2 * voxelsAt(T).g).isApprox(numericGradient(error, T, voxelsAt(T).centre), 1e-6));
}

TEST_F(Optimization, EdgeGradientIsThatOfTheErrorWithItsWeightsHeld) {
  addPairs(20, 0.3);
  const Eigen::Isometry3d T = poseOf(0.3, 0.1, -0.2, 5, 4, -3) * T_a_b;
  const NormalEquations n = edgesAt(T);
  const ErrorAt held = withWeightsHeldAt(
      T, pairs, model.centre, scene.centre, [&](const Pairs& p, const Eigen::Isometry3d& at) {
        return linearizeEdges(model_edges, scene_edges, p, at, VoxelCovariance::Quantisation);
      });
  ASSERT_NEAR(held(T), n.error, 1e-9 * n.error);
  EXPECT_TRUE((-2 * n.g).isApprox(numericGradient(held, T, n.centre), 1e-6));
  // A translation turns no covariance: there the weights need not be held.
  const auto error = [&](const auto& at) { return edgesAt(at).error; };
  EXPECT_TRUE((-2 * n.g.head<3>()).isApprox(numericGradient(error, T, n.centre).head<3>(), 1e-6));
}

TEST_F(Optimization, SurfaceGradientIsThatOfTheErrorWithItsWeightsHeld) {
  addPairs(20, 0.3);
  const Eigen::Isometry3d T = poseOf(0.3, 0.1, -0.2, 5, 4, -3) * T_a_b;
  const NormalEquations n = surfacesAt(T);
  const ErrorAt held = withWeightsHeldAt(
      T, pairs, model.centre, scene.centre, [&](const Pairs& p, const Eigen::Isometry3d& at) {
        return linearizeSurfaces(surfacesOf(model, model_normals), surfacesOf(scene, scene_normals),
                                 p, at, 0.05);
      });
  ASSERT_NEAR(held(T), n.error, 1e-9 * n.error);
  EXPECT_TRUE((-2 * n.g).isApprox(numericGradient(held, T, n.centre), 1e-6));
}

TEST_F(Optimization, ASurfaceOfWeightThreeCountsAsThree) {
  addPairs(5, 0.3);
  SurfaceVoxels of_scene = surfacesOf(scene, scene_normals);
  of_scene.surfaces.weight[2] = 3;
  Pairs repeated = pairs;
  repeated.push_back(pairs[2]);
  repeated.push_back(pairs[2]);
  const SurfaceVoxels of_model = surfacesOf(model, model_normals);
  const NormalEquations weighted = linearizeSurfaces(of_model, of_scene, pairs, T_a_b, 0.05);
  const NormalEquations thrice =
      linearizeSurfaces(of_model, surfacesOf(scene, scene_normals), repeated, T_a_b, 0.05);
  EXPECT_NEAR(weighted.error, thrice.error, 1e-9 * thrice.error);
  // Of the rest only what does not hang on the centre, the mean of the pairs.
  EXPECT_TRUE((weighted.H.topLeftCorner<3, 3>()).isApprox(thrice.H.topLeftCorner<3, 3>(), 1e-9));
  EXPECT_TRUE((weighted.g.head<3>()).isApprox(thrice.g.head<3>(), 1e-9));
}

TEST_F(Optimization, SurfaceErrorByHand) {
  // Two floors, 0.3 m apart along their normal and 0.4 m across it; the scene's frame is upside
  // down.
  T_a_b = poseOf(0, 0, 0, 0, 0, 180);
  addPair({1, 2, 3}, {0.4, 0, 0.3});
  model.probability = scene.probability = {1.F};  // eq. (22)'s factor: 1/2
  model_normals = {Eigen::Vector3f::UnitZ()};
  scene_normals = {Eigen::Vector3f::UnitZ()};
  // C = diag(2, 2, 2 flatness)
  EXPECT_NEAR(surfacesAt(T_a_b, 0.1).error, 0.5 * (0.16 / 2 + 0.09 / 0.2), 1e-6);
  model_normals[0].setZero();  // C = diag(2, 2, 1 + flatness)
  EXPECT_NEAR(surfacesAt(T_a_b, 0.1).error, 0.5 * (0.16 / 2 + 0.09 / 1.1), 1e-6);
  scene_normals[0].setZero();  // as eq. (22), but for C = 2 I
  EXPECT_NEAR(surfacesAt(T_a_b, 0.1).error, 0.5 * voxelsAt(T_a_b).error, 1e-9);
}

TEST_F(Optimization, SurfaceErrorIsWeightedByTheInverseOfBothCovariances) {
  addPairs(50, 0.3);
  model_normals[0].setZero();
  scene_normals[1].setZero();
  scene_normals[2] = (T_a_b.linear().transpose().cast<float>() * model_normals[2]).eval();
  for (const double flatness : {0.01, 0.3, 1.0}) {
    double expected = 0;
    for (const Pair& p : pairs) {
      const auto covariance = [&](const Eigen::Vector3d& n) {
        return Eigen::Matrix3d(Eigen::Matrix3d::Identity() - (1 - flatness) * n * n.transpose());
      };
      const Eigen::Vector3d e =
          model.centre[p.a].cast<double>() - T_a_b * scene.centre[p.b].cast<double>();
      const Eigen::Matrix3d C = covariance(model_normals[p.a].cast<double>()) +
                                covariance(T_a_b.linear() * scene_normals[p.b].cast<double>());
      const double factor = 1 / (1.0 / model.probability[p.a] + 1.0 / scene.probability[p.b]);
      expected += factor * e.dot(C.inverse() * e);
    }
    EXPECT_NEAR(surfacesAt(T_a_b, flatness).error, expected, 1e-4 * expected) << flatness;
  }
}

TEST_F(Optimization, ErrorAloneIsThatOfTheEquations) {
  addPairs(5000, 0.2);  // more than are added up at once
  const SurfaceVoxels of_model = surfacesOf(model, model_normals),
                      of_scene = surfacesOf(scene, scene_normals);
  for (const Eigen::Isometry3d& at : {T_a_b, Eigen::Isometry3d::Identity()}) {
    const double voxels = voxelsAt(at).error, edges = edgesAt(at).error,
                 surfaces = surfacesAt(at).error;
    EXPECT_NEAR(voxelError(model, scene, pairs, at), voxels, 1e-12 * voxels);
    EXPECT_NEAR(edgeError(model_edges, scene_edges, pairs, at, VoxelCovariance::Quantisation),
                edges, 1e-12 * edges);
    EXPECT_NEAR(surfaceError(of_model, of_scene, pairs, at, 0.05), surfaces, 1e-12 * surfaces);
  }
  EXPECT_EQ(voxelError(model, scene, {}, T_a_b), 0);
}

TEST_F(Optimization, SurfacesSlideAlongEachOther) {
  // Pairs on one floor, the model's 0.2 m above the scene's and 1 m aside.
  T_a_b.setIdentity();
  for (int i = 0; i < 30; i++) addPair({normal(), normal(), 0}, {1, 0, 0.2});
  model_normals.assign(30, Eigen::Vector3f::UnitZ());
  scene_normals = model_normals;
  SolverParams one_step;
  one_step.max_steps = 1;
  const Eigen::Isometry3d found = optimizePose(
      T_a_b, one_step, [&](const auto& at) { return surfacesAt(at, 1e-4); },
      [&](const auto& at) { return surfacesAt(at, 1e-4).error; });
  EXPECT_NEAR(found.translation().z(), 0.2, 1e-3);
  EXPECT_LE(surfacesAt(found, 1e-4).error, 1e-2 * surfacesAt(T_a_b, 1e-4).error);
}

TEST_F(Optimization, HessianIsThatOfTheErrorWhereThePairsFit) {
  addPairs(20, 0);
  const NormalEquations voxels = voxelsAt(T_a_b), edges = edgesAt(T_a_b),
                        surfaces = surfacesAt(T_a_b);
  EXPECT_TRUE((2 * voxels.H)
                  .isApprox(numericHessian([&](const auto& at) { return voxelsAt(at).error; },
                                           T_a_b, voxels.centre),
                            1e-4));
  EXPECT_TRUE((2 * edges.H)
                  .isApprox(numericHessian([&](const auto& at) { return edgesAt(at).error; }, T_a_b,
                                           edges.centre),
                            1e-4));
  EXPECT_TRUE((2 * surfaces.H)
                  .isApprox(numericHessian([&](const auto& at) { return surfacesAt(at).error; },
                                           T_a_b, surfaces.centre),
                            1e-4));
}

// ---------------------------------------------------------------- expSE3

TEST(ExpSE3, IsTheMatrixExponential) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const double angle : {0.0, 1e-12, 1e-8, 9e-5, 1.1e-4, 1e-3, 0.1, 1.0, 3.1, M_PI, 5.0}) {
    Eigen::Vector3d w(normal(random), normal(random), normal(random));
    w *= angle / w.norm();
    Vector6d xi;
    xi << 2 * normal(random), 2 * normal(random), 2 * normal(random), w;
    Eigen::Matrix4d twist = Eigen::Matrix4d::Zero();
    twist.topLeftCorner<3, 3>() << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
    twist.topRightCorner<3, 1>() = xi.head<3>();
    // The series of the exponential.
    Eigen::Matrix4d expected = Eigen::Matrix4d::Identity(), term = expected;
    for (int n = 1; n < 100; n++) expected += term = term * twist / n;
    EXPECT_LT((expSE3(xi).matrix() - expected).cwiseAbs().maxCoeff(), 1e-11) << angle;
  }
}

// ---------------------------------------------------------------- optimizePose

TEST_F(Optimization, OfEqualWeightsReachesTheClosedForm) {
  addPairs(60, 0.2);
  for (auto* set : {&model, &scene}) set->probability.assign(pairs.size(), 0.9F);
  const auto points = [](const OccupiedVoxels& v) {
    Eigen::Matrix3Xd m(3, v.size());
    for (size_t i = 0; i < v.size(); i++) m.col(i) = v.centre[i].cast<double>();
    return m;
  };
  const Eigen::Isometry3d closed_form(Eigen::umeyama(points(scene), points(model), false));
  // The last step bounds the error: the solver must take steps shorter than the tolerances below.
  const Eigen::Isometry3d found = optimizeVoxels(Eigen::Isometry3d::Identity(), {20, 1e-9, 1e-9});
  EXPECT_LT(metresBetween(found, closed_form), 1e-6);
  EXPECT_LT(degreesBetween(found, closed_form), 1e-5);
  EXPECT_GT(metresBetween(found, T_a_b), 1e-3);  // the noise has its say
}

TEST_F(Optimization, PairsOfTripleWeightCountAsThree) {
  addPairs(40, 0.3);
  for (auto* set : {&model, &scene}) set->probability.assign(pairs.size(), 0.3F);
  const Pairs once = pairs;
  for (size_t i = 0; i < 10; i++) pairs.insert(pairs.end(), {once[i], once[i]});
  const Eigen::Isometry3d repeated = optimizeVoxels(T_a_b);
  pairs = once;
  for (size_t i = 0; i < 10; i++) model.probability[i] = scene.probability[i] = 0.9F;
  const Eigen::Isometry3d weighted = optimizeVoxels(T_a_b);
  EXPECT_LT(metresBetween(repeated, weighted), 1e-6);
  EXPECT_LT(degreesBetween(repeated, weighted), 1e-5);
}

TEST_F(Optimization, RecoversAKnownPoseFromFarAway) {
  addPairs(50, 0);
  const Eigen::Isometry3d guess = poseOf(2, -3, 1, 30, 20, -10) * T_a_b;
  for (const auto& found : {optimizeVoxels(guess), optimizeEdges(guess)}) {
    EXPECT_LT(metresBetween(found, T_a_b), 1e-5);
    EXPECT_LT(degreesBetween(found, T_a_b), 1e-4);
  }
}

class OptimizationFarFromTheOrigin : public Optimization,
                                     public testing::WithParamInterface<double> {};

TEST_P(OptimizationFarFromTheOrigin, RecoversAKnownPose) {
  T_a_b = poseOf(GetParam(), -GetParam(), 0.5, 40, -15, 25);
  addPairs(50, 0);
  // The guess is off by 0.3 m and 5 deg, turned about the place of the scene.
  const Eigen::Vector3d place = T_a_b.translation();
  const Eigen::Isometry3d guess = Eigen::Translation3d(place) * poseOf(0.3, 0, 0, 4, 2, 2) *
                                  Eigen::Translation3d(-place) * T_a_b;
  for (const auto& found : {optimizeVoxels(guess), optimizeEdges(guess)}) {
    EXPECT_LT(metresBetween(found, T_a_b), 1e-2);
    EXPECT_LT(degreesBetween(found, T_a_b), 1e-2);
  }
}

// Metres. An octree of 0.1 m reaches out to 3.2 km, and georeferenced maps lie that far.
INSTANTIATE_TEST_SUITE_P(Optimization, OptimizationFarFromTheOrigin,
                         testing::Values(0.0, 100.0, 1000.0, 2000.0));

TEST_F(Optimization, NeverMakesTheErrorLarger) {
  addPairs(30, 1.0);
  for (int i = 0; i < 20; i++) {
    const Eigen::Isometry3d guess = poseOf(3 * normal(), 3 * normal(), 3 * normal(), 90 * normal(),
                                           30 * normal(), 30 * normal());
    for (const unsigned steps : {1U, 2U, 10U}) {
      SolverParams params;
      params.max_steps = steps;
      EXPECT_LE(voxelsAt(optimizeVoxels(guess, params)).error, voxelsAt(guess).error);
      EXPECT_LE(edgesAt(optimizeEdges(guess, params)).error, edgesAt(guess).error);
    }
  }
}

TEST_F(Optimization, StaysAtTheOptimum) {
  addPairs(30, 0);
  EXPECT_LT(metresBetween(optimizeVoxels(T_a_b), T_a_b), 1e-6);
  EXPECT_LT(degreesBetween(optimizeVoxels(T_a_b), T_a_b), 1e-5);
}

TEST_F(Optimization, OfPairsOnALineDoesNotTurnAboutIt) {
  // Along no axis and through no special point, so that nothing is zero by luck.
  const Eigen::Vector3d through(1, -2, 0.5), tau = Eigen::Vector3d(1, 2, -0.7).normalized();
  for (int i = 0; i < 40; i++) addPair(through + normal() * tau);
  const Eigen::Isometry3d guess = Eigen::Translation3d(0.4, -0.2, 0.3) * T_a_b;
  const Eigen::Isometry3d found = optimizeVoxels(guess);
  EXPECT_LT(voxelsAt(found).error, 1e-9);
  EXPECT_LT(degreesBetween(found, guess), 1e-3);
}

TEST_F(Optimization, OfPairsOnAPlaneFindsThePose) {
  const Eigen::Vector3d u = Eigen::Vector3d(1, 2, -0.7).normalized(), v = u.unitOrthogonal();
  for (int i = 0; i < 40; i++) addPair(Eigen::Vector3d(1, -2, 0.5) + normal() * u + normal() * v);
  const Eigen::Isometry3d found = optimizeVoxels(poseOf(0.4, -0.2, 0.3, 5, 5, 5) * T_a_b);
  EXPECT_LT(metresBetween(found, T_a_b), 1e-5);
  EXPECT_LT(degreesBetween(found, T_a_b), 1e-4);
}

TEST_F(Optimization, OfOneOrNoPairMovesNoFartherThanItMust) {
  EXPECT_EQ(optimizeVoxels(T_a_b).matrix(), T_a_b.matrix());
  EXPECT_EQ(optimizeEdges(T_a_b).matrix(), T_a_b.matrix());
  addPair({1, 1, 1}, {0.1, 0.2, 0.3});
  for (const auto& found : {optimizeVoxels(T_a_b), optimizeEdges(T_a_b)}) {
    ASSERT_TRUE(found.matrix().allFinite());
    EXPECT_LT(voxelsAt(found).error, 1e-9);
  }
}

// ---------------------------------------------------------------- covariances

TEST_F(Optimization, PoseCovarianceByHand) {
  T_a_b.setIdentity();
  for (int axis = 0; axis < 3; axis++)
    for (const double side : {-1.0, 1.0}) addPair(side * Eigen::Vector3d::Unit(axis));
  for (auto* set : {&model, &scene}) set->probability.assign(6, 1.F);
  // w = 1/2. Translation: sum of w = 3. Rotation: sum of w (|q|^2 - q_i^2) = 2.
  NormalEquations n = voxelsAt(T_a_b);
  n.error = 24;  // s^2 = 24 / (3 * 6 - 6) = 2
  const Matrix6d cov = poseCovariance(n, 6);
  Vector6d expected;
  expected << 2.0 / 3, 2.0 / 3, 2.0 / 3, 1, 1, 1;
  EXPECT_TRUE(cov.isApprox(Matrix6d(expected.asDiagonal()), 1e-9));
}

TEST_F(Optimization, PoseCovarianceIsTheSpreadOfManyEstimates) {
  constexpr int kTrials = 1500;
  constexpr double kNoise = 0.05;
  addPairs(12, 0);
  for (auto* set : {&model, &scene}) set->probability.assign(pairs.size(), 0.9F);
  const auto exact = model.centre;
  Matrix6d spread = Matrix6d::Zero(), predicted = Matrix6d::Zero();
  for (int trial = 0; trial < kTrials; trial++) {
    for (size_t i = 0; i < exact.size(); i++)
      model.centre[i] = exact[i] + (kNoise * normalVector()).cast<float>();
    const Eigen::Isometry3d found = optimizeVoxels(T_a_b);
    predicted += poseCovariance(voxelsAt(found), pairs.size()) / kTrials;
    const Eigen::Isometry3d error = found * T_a_b.inverse();  // exp(xi), xi small
    const Eigen::AngleAxisd turn(error.linear());
    Vector6d xi;
    xi << error.translation(), turn.angle() * turn.axis();
    spread += xi * xi.transpose() / kTrials;
  }
  // Each variance, in the principal axes of the prediction, within what 1500 trials can tell.
  const SymmetricEigen<6> axes(predicted);
  const Vector6d ratio = (axes.eigenvectors.transpose() * spread * axes.eigenvectors)
                             .diagonal()
                             .cwiseQuotient(axes.eigenvalues);
  EXPECT_GT(ratio.minCoeff(), 0.8);
  EXPECT_LT(ratio.maxCoeff(), 1.25);
}

TEST_F(Optimization, GradientScatterByHand) {
  T_a_b.setIdentity();
  // Two pairs in one patch of 2 m, one in another; w = 1/2.
  addPair({0.5, 0.5, 0.5}, {1, 0, 0});
  addPair({1.5, 0.5, 0.5}, {0, 1, 0});
  addPair({3.5, 0.5, 0.5}, {0, 0, 1});
  for (auto* set : {&model, &scene}) set->probability.assign(3, 1.F);
  const GradientScatter scatter =
      scatterVoxels(model, scene, pairs, T_a_b, Eigen::Vector3d(0.5, 0.5, 0.5), 2);
  Vector6d first, second;  // sums of w e, and of r x w e
  first << 0.5, 0.5, 0, 0, 0, 0.5;
  second << 0, 0, 0.5, 0, -1.5, 0;
  EXPECT_EQ(scatter.patches, 2U);
  EXPECT_TRUE(scatter.S.isApprox(first * first.transpose() + second * second.transpose(), 1e-6));
}

TEST_F(Optimization, PoseCovarianceCountsWhatPatchesHaveInCommon) {
  // Each patch of many pairs is shifted as a whole, as pieces of a map that drifted.
  constexpr int kTrials = 300, kPerPatch = 20;
  constexpr double kNoise = 0.05, kSide = 6;
  std::vector<size_t> patch;
  size_t patches = 0;
  for (int x = -2; x <= 2; x++)
    for (int y = -2; y <= 2; y++)
      for (int z = 0; z <= 1; z++, patches++)
        for (int i = 0; i < kPerPatch; i++) {
          addPair(kSide * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) +
                  Eigen::Vector3d::Random() * 2);
          patch.push_back(patches);
        }
  for (auto* set : {&model, &scene}) set->probability.assign(pairs.size(), 0.9F);
  const auto exact = model.centre;
  Matrix6d spread = Matrix6d::Zero(), predicted = Matrix6d::Zero(), independent = spread;
  for (int trial = 0; trial < kTrials; trial++) {
    std::vector<Eigen::Vector3f> shift;
    for (size_t k = 0; k < patches; k++) shift.push_back((kNoise * normalVector()).cast<float>());
    for (size_t i = 0; i < exact.size(); i++) model.centre[i] = exact[i] + shift[patch[i]];
    const Eigen::Isometry3d found = optimizeVoxels(T_a_b);
    const NormalEquations n = voxelsAt(found);
    const GradientScatter scatter = scatterVoxels(model, scene, pairs, found, n.centre, kSide);
    EXPECT_EQ(scatter.patches, patches);
    predicted += poseCovariance(n, pairs.size(), scatter) / kTrials;
    independent += poseCovariance(n, pairs.size()) / kTrials;
    const Eigen::Isometry3d error = found * T_a_b.inverse();
    const Eigen::AngleAxisd turn(error.linear());
    Vector6d xi;
    xi << error.translation(), turn.angle() * turn.axis();
    spread += xi * xi.transpose() / kTrials;
  }
  const auto ratioTo = [&](const Matrix6d& covariance) {
    return (covariance.inverse() * spread).trace() / 6;  // the mean NEES over its freedom
  };
  EXPECT_GT(ratioTo(predicted), 0.7);
  EXPECT_LT(ratioTo(predicted), 1.4);
  EXPECT_GT(ratioTo(independent), 5) << "20 pairs each are but one";
}

TEST_F(Optimization, PoseCovarianceSaysWhereItKnowsNothing) {
  EXPECT_TRUE(
      poseCovariance(NormalEquations(), 0, {}, 7.0).isApprox(7 * Matrix6d::Identity(), 1e-9));

  // A line along z through the origin: nothing is known about turns around it, all else is.
  T_a_b.setIdentity();
  for (int i = -5; i <= 5; i++) addPair({0, 0, 0.2 * i}, 0.05 * normalVector());
  const Matrix6d cov =
      poseCovariance(voxelsAt(Eigen::Isometry3d::Identity()), pairs.size(), {}, 1e6);
  EXPECT_NEAR(cov(5, 5), 1e6, 1);
  EXPECT_LT(cov.diagonal().head<5>().maxCoeff(), 1);
  EXPECT_TRUE(cov.allFinite());
}

TEST_F(Optimization, PoseCovarianceOfAPerfectFitIsNotSingular) {
  addPairs(50, 0);
  const Matrix6d cov = poseCovariance(voxelsAt(T_a_b), pairs.size());
  EXPECT_GT(SymmetricEigen<6>(cov).eigenvalues[0], 0);
}

/** (x, y, z, yaw, pitch, roll) as MRPT has them. */
Vector6d angles(const Eigen::Isometry3d& T) {
  const auto pose = toPose(T);
  Vector6d v;
  v << pose.x(), pose.y(), pose.z(), pose.yaw(), pose.pitch(), pose.roll();
  return v;
}

TEST_F(Optimization, YawPitchRollCovarianceIsThatOfTheNumericJacobian) {
  for (const auto& T : {poseOf(0, 0, 0, 0), T_a_b, poseOf(-10, 4, 2, 179.999, 60, -170),
                        poseOf(1, 20, -3, -100, -80, 5)}) {
    const Matrix6d a = Matrix6d::NullaryExpr([&] { return normal(); });
    const Matrix6d covariance = a * a.transpose();
    constexpr double h = 1e-6;
    Matrix6d J;
    for (int i = 0; i < 6; i++) {
      Vector6d change = angles(expSE3(unit(i, h)) * T) - angles(expSE3(unit(i, -h)) * T);
      for (int k = 3; k < 6; k++) change[k] = mrpt::math::wrapToPi(change[k]);
      J.col(i) = change / (2 * h);
    }
    const Matrix6d expected = J * covariance * J.transpose();
    EXPECT_TRUE(toYawPitchRollCovariance(covariance, T).isApprox(expected, 1e-6));
  }
}

TEST(Poses, GoFromEigenToMrptAndBack) {
  const Eigen::Isometry3d T = poseOf(1, -2, 3, 50, -20, 130);
  const mrpt::poses::CPose3D pose = toPose(T);
  EXPECT_NEAR(pose.yaw(), 50 * kDegree, 1e-12);
  EXPECT_NEAR(pose.pitch(), -20 * kDegree, 1e-12);
  EXPECT_NEAR(pose.roll(), 130 * kDegree, 1e-12);
  EXPECT_TRUE(toEigen(pose).isApprox(T, 1e-12));
}

}  // namespace
}  // namespace mrpt::fusion::test::optimization_test
