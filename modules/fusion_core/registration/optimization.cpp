// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/registration/optimization.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "fusion_base/parallel.h"

namespace mrpt::fusion {
namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/** By the step about a centre \a from, that about \a to which moves everything alike. */
Matrix6d stepAbout(const Eigen::Vector3d& to, const Eigen::Vector3d& from) {
  Matrix6d J = Matrix6d::Identity();  // turning by w about from moves to by w x (to - from)
  J.topRightCorner<3, 3>() = skew(from - to);
  return J;
}

/** Has an element in the cache by the time that it is needed. */
template <class T>
void prefetch(const std::vector<T>& v, size_t i) {
  __builtin_prefetch(&v[i]);
}

/** The sums over parts of the pairs: what is added up when does not hang on the threads. The model
 * voxels of pairs lie anywhere in memory: \a term is told of them a little ahead. */
template <class Sums, class TermOf, class Add>
std::vector<Sums> sumsOfParts(const Pairs& pairs, const TermOf& term, Add&& add) {
  constexpr size_t kPairs = 2000;  // of a part
  constexpr size_t kAhead = 12;
  std::vector<Sums> parts((pairs.size() + kPairs - 1) / kPairs);
  forEachIndex(parts.size(), 1, [&](size_t part) {
    Sums sums{};
    for (size_t i = part * kPairs; i < std::min(pairs.size(), (part + 1) * kPairs); i++) {
      if (i + kAhead < pairs.size()) term.prefetch(pairs[i + kAhead]);
      add(sums, pairs[i]);
    }
    parts[part] = sums;
  });
  return parts;
}

/** A pair's e = m - T s and its weight, a matrix or what has a matrix() and a squaredLength(e). */
template <class Weight>
struct Term {
  Eigen::Vector3d e;
  Weight W;
};
const Eigen::Matrix3d& matrixOf(const Eigen::Matrix3d& W) { return W; }
template <class Weight>
Eigen::Matrix3d matrixOf(const Weight& W) {
  return W.matrix();
}
double squaredLength(const Eigen::Vector3d& e, const Eigen::Matrix3d& W) { return e.dot(W * e); }
template <class Weight>
double squaredLength(const Eigen::Vector3d& e, const Weight& W) {
  return W.squaredLength(e);
}

/** Adds up the terms of pairs, each given by \a term at q = T s.
 * Moving by xi takes e to e - J xi with J = [I, -[r]x] at r = q - c. */
template <class TermOf>
NormalEquations sumOf(const std::vector<Eigen::Vector3f>& scene, const Pairs& pairs,
                      const Eigen::Isometry3d& T, const TermOf& term) {
  NormalEquations n;
  if (pairs.empty()) return n;
  // About one of them at first: their middle is known when all have been looked at.
  n.centre = T * scene[pairs[pairs.size() / 2].scene].template cast<double>();
  struct Sums {
    Eigen::Vector3d scene = Eigen::Vector3d::Zero();
    Eigen::Matrix3d tt = Eigen::Matrix3d::Zero(), rt = tt, rr = tt;  // blocks of H
    Vector6d g = Vector6d::Zero();
    double error = 0;
  };
  const auto parts = sumsOfParts<Sums>(pairs, term, [&](Sums& sums, const Pair& p) {
    const Eigen::Vector3d s = scene[p.scene].cast<double>(), q = T * s;
    const auto [e, weight] = term(p, q);
    const Eigen::Matrix3d W = matrixOf(weight);
    const Eigen::Vector3d r = q - n.centre, We = W * e;
    Eigen::Matrix3d rW, rWr;  // [r]x W, and ([r]x W) [r]x' by its rows
    for (int k = 0; k < 3; k++) rW.col(k) = r.cross(W.col(k));
    for (int k = 0; k < 3; k++) rWr.col(k) = r.cross(rW.row(k).transpose());
    sums.scene += s;
    sums.tt += W;
    sums.rt += rW;
    sums.rr += rWr;
    sums.g.template head<3>() += We;
    sums.g.template tail<3>() += r.cross(We);  // (-[r]x)' = [r]x
    sums.error += e.dot(We);
  });
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Sums& sums : parts) {
    middle += sums.scene;
    Matrix6d H;
    H << sums.tt, sums.rt.transpose(), sums.rt, sums.rr;
    n.H += H;
    n.g += sums.g;
    n.error += sums.error;
  }
  return n.about(T * (middle / static_cast<double>(pairs.size())));
}

/** The error alone. */
template <class TermOf>
double errorOf(const std::vector<Eigen::Vector3f>& scene, const Pairs& pairs,
               const Eigen::Isometry3d& T, const TermOf& term) {
  const auto parts = sumsOfParts<double>(pairs, term, [&](double& sum, const Pair& p) {
    const auto [e, W] = term(p, T * scene[p.scene].cast<double>());
    sum += squaredLength(e, W);
  });
  return std::accumulate(parts.begin(), parts.end(), 0.0);
}

/** The scatter of the gradients of patches, the scene's cubes of a side, see GradientScatter. */
template <class TermOf>
GradientScatter scatterOf(const std::vector<Eigen::Vector3f>& scene, const Pairs& pairs,
                          const Eigen::Isometry3d& T, const Eigen::Vector3d& centre, double side,
                          const TermOf& term) {
  std::map<std::array<int, 3>, Vector6d> patches;
  for (const Pair& p : pairs) {
    const Eigen::Vector3d s = scene[p.scene].cast<double>(), q = T * s;
    const auto [e, W] = term(p, q);
    const Eigen::Vector3d We = matrixOf(W) * e;
    const auto part = [side](double x) { return static_cast<int>(std::floor(x / side)); };
    const auto found =
        patches.try_emplace({part(s.x()), part(s.y()), part(s.z())}, Vector6d::Zero());
    Vector6d& g = found.first->second;
    g.head<3>() += We;
    g.tail<3>() += (q - centre).cross(We);
  }
  GradientScatter scatter;
  scatter.patches = patches.size();
  for (const auto& [place, g] : patches) scatter.S += g * g.transpose();
  return scatter;
}

/** Eq. (22)'s weight of a pair. */
double occupancyFactor(const OccupiedVoxels& model, const OccupiedVoxels& scene, const Pair& p) {
  const auto p_m = static_cast<double>(model.probability[p.model]),
             p_s = static_cast<double>(scene.probability[p.scene]);
  return p_m * p_s / (p_m + p_s);  // with a division less
}

/** A factor times (C_m + C_s)^-1 of two surfaces, C = I - (1 - flatness) n n' with n a unit vector
 * or zero.
 *
 * In closed form: with k = 1 - flatness and c = n_m . n_s, the sum has the eigenvectors n_m + n_s,
 * n_m - n_s and what is normal to both, and the eigenvalues 2 - k (1 + c), 2 - k (1 - c) and 2. */
class SurfaceWeight {
 public:
  SurfaceWeight(const Eigen::Vector3d& n_m, const Eigen::Vector3d& n_s, double flatness,
                double factor)
      : n_m_(n_m), n_s_(n_s), of_all_(0.5 * factor) {
    const double k = 1 - flatness, c = n_m.dot(n_s);
    const double by_sum = 2 - k * (1 + c), by_difference = 2 - k * (1 - c);
    const double common = 0.25 * k * factor / (by_sum * by_difference);
    of_sum_ = common * by_difference;
    of_difference_ = common * by_sum;
  }
  Eigen::Matrix3d matrix() const {
    const Eigen::Vector3d sum = n_m_ + n_s_, difference = n_m_ - n_s_;
    return of_all_ * Eigen::Matrix3d::Identity() + (of_sum_ * sum) * sum.transpose() +
           (of_difference_ * difference) * difference.transpose();
  }
  double squaredLength(const Eigen::Vector3d& e) const {
    const double m = n_m_.dot(e), s = n_s_.dot(e);
    return of_all_ * e.squaredNorm() + of_sum_ * (m + s) * (m + s) +
           of_difference_ * (m - s) * (m - s);
  }

 private:
  Eigen::Vector3d n_m_, n_s_;
  double of_all_, of_sum_, of_difference_;
};

/** Of two edge voxels, by what is known of each one's place. */
class EdgeTerm {
 public:
  EdgeTerm(const EdgeVoxels& model, const EdgeVoxels& scene, const Eigen::Isometry3d& T_a_b,
           VoxelCovariance kind)
      : model_(model), scene_(scene), R_(T_a_b.linear()), kind_(kind) {}

  Term<Eigen::Matrix3d> operator()(const Pair& p, const Eigen::Vector3d& q) const {
    return {model_.centre[p.model].cast<double>() - q,
            (fused(model_, p.model) + R_ * fused(scene_, p.scene) * R_.transpose()).inverse()};
  }
  void prefetch(const Pair&) const {}  // these are few

 private:
  Eigen::Matrix3d fused(const EdgeVoxels& edges, uint32_t i) const {
    // Across a perfect line the neighbours do not spread, but each sits somewhere in its voxel.
    const double within_voxel = edges.resolution * edges.resolution / 12;
    return fuseCovariances(voxelVariance(edges.probability[i], edges.resolution, kind_),
                           edges.covariance[i].matrix(within_voxel));
  }

  const EdgeVoxels &model_, &scene_;
  const Eigen::Matrix3d R_;
  const VoxelCovariance kind_;
};

/** Of two voxels, by their occupancy alone. */
class VoxelTerm {
 public:
  VoxelTerm(const OccupiedVoxels& model, const OccupiedVoxels& scene)
      : model_(model), scene_(scene) {}

  Term<Eigen::Matrix3d> operator()(const Pair& p, const Eigen::Vector3d& q) const {
    return {model_.centre[p.model].cast<double>() - q,
            occupancyFactor(model_, scene_, p) * Eigen::Matrix3d::Identity()};
  }
  void prefetch(const Pair& p) const {
    fusion::prefetch(model_.centre, p.model);
    fusion::prefetch(model_.probability, p.model);
  }

 private:
  const OccupiedVoxels &model_, &scene_;
};

/** Of two pieces of surface. */
class SurfaceTerm {
 public:
  SurfaceTerm(const OccupiedVoxels& model, const Surfaces& model_surface,
              const OccupiedVoxels& scene, const Surfaces& scene_surface,
              const Eigen::Isometry3d& T_a_b, double flatness)
      : model_(model),
        scene_(scene),
        model_surface_(model_surface),
        scene_surface_(scene_surface),
        R_(T_a_b.linear()),
        flatness_(flatness) {}

  Term<SurfaceWeight> operator()(const Pair& p, const Eigen::Vector3d& q) const {
    const double weight = static_cast<double>(scene_surface_.weight[p.scene]);
    return {model_surface_.point[p.model].cast<double>() - q,
            {model_surface_.normal[p.model].cast<double>(),
             R_ * scene_surface_.normal[p.scene].cast<double>(), flatness_,
             weight * occupancyFactor(model_, scene_, p)}};
  }
  void prefetch(const Pair& p) const {
    fusion::prefetch(model_surface_.point, p.model);
    fusion::prefetch(model_surface_.normal, p.model);
    fusion::prefetch(model_.probability, p.model);
  }

 private:
  const OccupiedVoxels &model_, &scene_;
  const Surfaces &model_surface_, &scene_surface_;
  const Eigen::Matrix3d R_;
  const double flatness_;
};

}  // namespace

NormalEquations NormalEquations::about(const Eigen::Vector3d& other) const {
  const Matrix6d J = stepAbout(centre, other);
  return {J.transpose() * H * J, J.transpose() * g, error, other};
}

NormalEquations linearizeEdges(const EdgeVoxels& model, const EdgeVoxels& scene, const Pairs& pairs,
                               const Eigen::Isometry3d& T_a_b, VoxelCovariance kind) {
  return sumOf(scene.centre, pairs, T_a_b, EdgeTerm(model, scene, T_a_b, kind));
}

double edgeError(const EdgeVoxels& model, const EdgeVoxels& scene, const Pairs& pairs,
                 const Eigen::Isometry3d& T_a_b, VoxelCovariance kind) {
  return errorOf(scene.centre, pairs, T_a_b, EdgeTerm(model, scene, T_a_b, kind));
}

NormalEquations linearizeVoxels(const OccupiedVoxels& model, const OccupiedVoxels& scene,
                                const Pairs& pairs, const Eigen::Isometry3d& T_a_b) {
  return sumOf(scene.centre, pairs, T_a_b, VoxelTerm(model, scene));
}

double voxelError(const OccupiedVoxels& model, const OccupiedVoxels& scene, const Pairs& pairs,
                  const Eigen::Isometry3d& T_a_b) {
  return errorOf(scene.centre, pairs, T_a_b, VoxelTerm(model, scene));
}

GradientScatter scatterVoxels(const OccupiedVoxels& model, const OccupiedVoxels& scene,
                              const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                              const Eigen::Vector3d& centre, double side) {
  return scatterOf(scene.centre, pairs, T_a_b, centre, side, VoxelTerm(model, scene));
}

NormalEquations linearizeSurfaces(const OccupiedVoxels& model, const Surfaces& model_surface,
                                  const OccupiedVoxels& scene, const Surfaces& scene_surface,
                                  const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                                  double flatness) {
  return sumOf(scene_surface.point, pairs, T_a_b,
               SurfaceTerm(model, model_surface, scene, scene_surface, T_a_b, flatness));
}

double surfaceError(const OccupiedVoxels& model, const Surfaces& model_surface,
                    const OccupiedVoxels& scene, const Surfaces& scene_surface, const Pairs& pairs,
                    const Eigen::Isometry3d& T_a_b, double flatness) {
  return errorOf(scene_surface.point, pairs, T_a_b,
                 SurfaceTerm(model, model_surface, scene, scene_surface, T_a_b, flatness));
}

GradientScatter scatterSurfaces(const OccupiedVoxels& model, const Surfaces& model_surface,
                                const OccupiedVoxels& scene, const Surfaces& scene_surface,
                                const Pairs& pairs, const Eigen::Isometry3d& T_a_b, double flatness,
                                const Eigen::Vector3d& centre, double side) {
  return scatterOf(scene_surface.point, pairs, T_a_b, centre, side,
                   SurfaceTerm(model, model_surface, scene, scene_surface, T_a_b, flatness));
}

Eigen::Isometry3d expSE3(const Vector6d& xi) {
  const Eigen::Vector3d w = xi.tail<3>();
  const double angle = w.norm();
  const Eigen::Matrix3d W = skew(w);
  double a = 0.5, b = 1.0 / 6;  // (1 - cos)/angle^2 and (angle - sin)/angle^3
  if (angle > 1e-4) {
    a = (1 - std::cos(angle)) / (angle * angle);
    b = (angle - std::sin(angle)) / (angle * angle * angle);
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (angle > 0) T.linear() = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  T.translation() = (Eigen::Matrix3d::Identity() + a * W + b * W * W) * xi.head<3>();
  return T;
}

Eigen::Isometry3d perturb(const Eigen::Isometry3d& T, const Vector6d& xi,
                          const Eigen::Vector3d& centre) {
  return Eigen::Translation3d(centre) * expSE3(xi) * Eigen::Translation3d(-centre) * T;
}

namespace {
/** Eigenvalues of H below this share of the largest are rounding, not information. */
constexpr double kNoInformation = 1e-10;
}  // namespace

Vector6d solveDamped(const NormalEquations& equations, double lambda) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(equations.H);
  const auto& values = solver.eigenvalues();  // ascending
  const double least = kNoInformation * values[5];
  int unknown = 0;
  while (unknown < 6 && !(values[unknown] > least)) unknown++;
  if (unknown == 6) return Vector6d::Zero();
  const Eigen::MatrixXd V = solver.eigenvectors().rightCols(6 - unknown);
  Matrix6d H = equations.H;
  H.diagonal() *= 1 + lambda;
  const Eigen::MatrixXd reduced = V.transpose() * H * V;
  return V * reduced.ldlt().solve(V.transpose() * equations.g);
}

PoseDeviation deviationAt(const Matrix6d& covariance, const Eigen::Vector3d& point) {
  Eigen::Matrix<double, 3, 6> J;  // of the point
  J << Eigen::Matrix3d::Identity(), -skew(point);
  const auto largest = [](const Eigen::Matrix3d& m) {
    return std::sqrt(
        std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m, Eigen::EigenvaluesOnly)
                          .eigenvalues()[2]));
  };
  return {largest(J * covariance * J.transpose()), largest(covariance.bottomRightCorner<3, 3>())};
}

Matrix6d poseCovariance(const NormalEquations& at_optimum, size_t pairs,
                        const GradientScatter& scatter, double unknown_variance) {
  const double freedom = std::max(1.0, 3 * static_cast<double>(pairs) - 6);
  const double residual_variance = std::max(at_optimum.error / freedom, 1e-12);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(at_optimum.H);
  const auto& V = solver.eigenvectors();
  Vector6d inverse = Vector6d::Zero(), unknown = Vector6d::Zero();
  int known = 0;
  for (int i = 0; i < 6; i++) {
    const double value = solver.eigenvalues()[i];
    if (value > kNoInformation * solver.eigenvalues()[5]) {
      inverse[i] = 1 / value;
      known++;
    } else {
      unknown[i] = unknown_variance;
    }
  }
  const Matrix6d inverse_H = V * inverse.asDiagonal() * V.transpose();
  const double patches = static_cast<double>(scatter.patches);
  const double correlated = known > 0 ? (inverse_H * scatter.S).trace() / known : 0;
  const double shrinkage = 6 / (6 + patches);
  const Matrix6d about_centre = (residual_variance + shrinkage * correlated) * inverse_H +
                                (1 - shrinkage) * inverse_H * scatter.S * inverse_H +
                                V * unknown.asDiagonal() * V.transpose();
  const Matrix6d J = stepAbout(Eigen::Vector3d::Zero(), at_optimum.centre);
  return J * about_centre * J.transpose();
}

}  // namespace mrpt::fusion
