// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Adds up the errors of pairs, in parts that do not depend on the number of threads. */
#include "fusion_core/registration/residuals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "fusion_base/bits.h"
#include "fusion_base/parallel.h"
#include "fusion_base/whole_number.h"
#include "fusion_core/features/uncertainty.h"

namespace mrpt::fusion {
namespace {

/** Returns the sums over parts of the pairs. The order of the additions does not depend on the
 * threads. The voxels of A are scattered in memory: \a term prefetches them. */
template <class Sums, class TermOf, class Add>
std::vector<Sums> sumsOfParts(const Pairs& pairs, const TermOf& term, Add&& add) {
  constexpr size_t kPairs = 2000;  // pairs in a part
  constexpr size_t kAhead = 12;    // distance of the prefetch, pairs
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

/** Error e = m - T s of a pair and its weight. The weight is a matrix, or has matrix() and
 * squaredLength(e). The point of A is m, the point of B is s, as in the paper. */
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

/** Adds up the terms of pairs. \a term returns the term of a pair at q = T s. A step xi changes e
 * to e - J xi with J = [I, -[r]x] at r = q - c. */
template <class TermOf>
NormalEquations sumOf(const std::vector<Eigen::Vector3f>& b, const Pairs& pairs,
                      const Eigen::Isometry3d& T, const TermOf& term) {
  NormalEquations n;
  if (pairs.empty()) return n;
  // The first centre is a point of B: the mean is known only after the sum.
  n.centre = T * b[pairs[pairs.size() / 2].b].template cast<double>();
  struct Sums {
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    Eigen::Matrix3d tt = Eigen::Matrix3d::Zero(), rt = tt, rr = tt;  // blocks of H
    Vector6d g = Vector6d::Zero();
    double error = 0;
  };
  const auto parts = sumsOfParts<Sums>(pairs, term, [&](Sums& sums, const Pair& p) {
    const Eigen::Vector3d s = b[p.b].cast<double>(), q = T * s;
    const auto [e, weight] = term(p, q);
    const Eigen::Matrix3d W = matrixOf(weight);
    const Eigen::Vector3d r = q - n.centre, We = W * e;
    Eigen::Matrix3d rW, rWr;  // [r]x W, and ([r]x W) [r]x' by its rows
    for (int k = 0; k < 3; k++) rW.col(k) = r.cross(W.col(k));
    for (int k = 0; k < 3; k++) rWr.col(k) = r.cross(rW.row(k).transpose());
    sums.b += s;
    sums.tt += W;
    sums.rt += rW;
    sums.rr += rWr;
    sums.g.template head<3>() += We;
    sums.g.template tail<3>() += r.cross(We);  // (-[r]x)' = [r]x
    sums.error += e.dot(We);
  });
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Sums& sums : parts) {
    middle += sums.b;
    Matrix6d H;
    H << sums.tt, sums.rt.transpose(), sums.rt, sums.rr;
    n.H += H;
    n.g += sums.g;
    n.error += sums.error;
  }
  return n.about(T * (middle / static_cast<double>(pairs.size())));
}

/** Returns only the error. */
template <class TermOf>
double errorOf(const std::vector<Eigen::Vector3f>& b, const Pairs& pairs,
               const Eigen::Isometry3d& T, const TermOf& term) {
  const auto parts = sumsOfParts<double>(pairs, term, [&](double& sum, const Pair& p) {
    const auto [e, W] = term(p, T * b[p.b].cast<double>());
    sum += squaredLength(e, W);
  });
  return std::accumulate(parts.begin(), parts.end(), 0.0);
}

using Patch = std::array<int, 3>;

/** Returns the cube of B in which a point lies. \a side is the side of the cubes, m. */
Patch patchOf(const Eigen::Vector3d& s, double side) {
  const auto part = [side](double x) { return toWhole(std::floor(x / side)); };
  return {part(s.x()), part(s.y()), part(s.z())};
}

/** Returns the scatter of the gradients of patches, which are cubes of B. See GradientScatter.
 * \a side is the side of the cubes, m. */
template <class TermOf>
GradientScatter scatterOf(const std::vector<Eigen::Vector3f>& b, const Pairs& pairs,
                          const Eigen::Isometry3d& T, const Eigen::Vector3d& centre, double side,
                          const TermOf& term) {
  std::map<Patch, Vector6d> patches;
  for (const Pair& p : pairs) {
    const Eigen::Vector3d s = b[p.b].cast<double>(), q = T * s;
    const auto [e, W] = term(p, q);
    const Eigen::Vector3d We = matrixOf(W) * e;
    const auto found = patches.try_emplace(patchOf(s, side), Vector6d::Zero());
    Vector6d& g = found.first->second;
    g.head<3>() += We;
    g.tail<3>() += (q - centre).cross(We);
  }
  GradientScatter scatter;
  scatter.patches = patches.size();
  for (const auto& [place, g] : patches) scatter.S += g * g.transpose();
  return scatter;
}

/** Returns the weight of a pair, eq. (22). */
double occupancyFactor(const OccupiedVoxels& a, const OccupiedVoxels& b, const Pair& p) {
  const auto p_m = static_cast<double>(a.probability[p.a]),
             p_s = static_cast<double>(b.probability[p.b]);
  return p_m * p_s / (p_m + p_s);  // saves a division
}

/** Weight of a pair of surfaces: a factor times (C_m + C_s)^-1. C = I - (1 - flatness) n n', where
 * n is a unit vector or zero. Index m is the surface of A, index s is the surface of B.
 *
 * The inverse has a closed form. With k = 1 - flatness and c = n_m . n_s, the sum has the
 * eigenvectors n_m + n_s, n_m - n_s and the vectors normal to both. The eigenvalues are
 * 2 - k (1 + c), 2 - k (1 - c) and 2. */
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

/** Term of two edge voxels, weighted by the covariances of their positions. */
class EdgeTerm {
 public:
  EdgeTerm(const EdgeVoxels& a, const EdgeVoxels& b, const Eigen::Isometry3d& T_a_b,
           VoxelCovariance kind)
      : a_(a), b_(b), R_(T_a_b.linear()), kind_(kind) {}

  Term<Eigen::Matrix3d> operator()(const Pair& p, const Eigen::Vector3d& q) const {
    return {a_.centre[p.a].cast<double>() - q,
            (fused(a_, p.a) + R_ * fused(b_, p.b) * R_.transpose()).inverse()};
  }
  void prefetch(const Pair&) const {}  // not needed: edge pairs are few

 private:
  Eigen::Matrix3d fused(const EdgeVoxels& edges, uint32_t i) const {
    // The neighbours on a perfect line have no extent across it, but each has a position in its
    // voxel.
    const double within_voxel = edges.resolution * edges.resolution / 12;
    return fuseCovariances(voxelVariance(edges.probability[i], edges.resolution, kind_),
                           edges.covariance[i].matrix(within_voxel));
  }

  const EdgeVoxels &a_, &b_;
  const Eigen::Matrix3d R_;
  const VoxelCovariance kind_;
};

/** Term of two voxels, weighted by their occupancy only. */
class VoxelTerm {
 public:
  VoxelTerm(const OccupiedVoxels& a, const OccupiedVoxels& b) : a_(a), b_(b) {}

  Term<Eigen::Matrix3d> operator()(const Pair& p, const Eigen::Vector3d& q) const {
    return {a_.centre[p.a].cast<double>() - q,
            occupancyFactor(a_, b_, p) * Eigen::Matrix3d::Identity()};
  }
  void prefetch(const Pair& p) const {
    fusion::prefetch(a_.centre, p.a);
    fusion::prefetch(a_.probability, p.a);
  }

 private:
  const OccupiedVoxels &a_, &b_;
};

/** Term of two surfaces. */
class SurfaceTerm {
 public:
  SurfaceTerm(const SurfaceVoxels& a, const SurfaceVoxels& b, const Eigen::Isometry3d& T_a_b,
              double flatness)
      : a_(a), b_(b), R_(T_a_b.linear()), flatness_(flatness) {}

  Term<SurfaceWeight> operator()(const Pair& p, const Eigen::Vector3d& q) const {
    const double weight = static_cast<double>(b_.surfaces.weight[p.b]);
    return {a_.surfaces.point[p.a].cast<double>() - q,
            {a_.surfaces.normal[p.a].cast<double>(), R_ * b_.surfaces.normal[p.b].cast<double>(),
             flatness_, weight * occupancyFactor(a_.voxels, b_.voxels, p)}};
  }
  void prefetch(const Pair& p) const {
    fusion::prefetch(a_.surfaces.point, p.a);
    fusion::prefetch(a_.surfaces.normal, p.a);
    fusion::prefetch(a_.voxels.probability, p.a);
  }

 private:
  const SurfaceVoxels &a_, &b_;
  const Eigen::Matrix3d R_;
  const double flatness_;
};

}  // namespace

NormalEquations linearizeEdges(const EdgeVoxels& a, const EdgeVoxels& b, const Pairs& pairs,
                               const Eigen::Isometry3d& T_a_b, VoxelCovariance kind) {
  return sumOf(b.centre, pairs, T_a_b, EdgeTerm(a, b, T_a_b, kind));
}

double edgeError(const EdgeVoxels& a, const EdgeVoxels& b, const Pairs& pairs,
                 const Eigen::Isometry3d& T_a_b, VoxelCovariance kind) {
  return errorOf(b.centre, pairs, T_a_b, EdgeTerm(a, b, T_a_b, kind));
}

NormalEquations linearizeVoxels(const OccupiedVoxels& a, const OccupiedVoxels& b,
                                const Pairs& pairs, const Eigen::Isometry3d& T_a_b) {
  return sumOf(b.centre, pairs, T_a_b, VoxelTerm(a, b));
}

double voxelError(const OccupiedVoxels& a, const OccupiedVoxels& b, const Pairs& pairs,
                  const Eigen::Isometry3d& T_a_b) {
  return errorOf(b.centre, pairs, T_a_b, VoxelTerm(a, b));
}

GradientScatter scatterVoxels(const OccupiedVoxels& a, const OccupiedVoxels& b, const Pairs& pairs,
                              const Eigen::Isometry3d& T_a_b, const Eigen::Vector3d& centre,
                              double side) {
  return scatterOf(b.centre, pairs, T_a_b, centre, side, VoxelTerm(a, b));
}

NormalEquations linearizeSurfaces(const SurfaceVoxels& a, const SurfaceVoxels& b,
                                  const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                                  double flatness) {
  return sumOf(b.surfaces.point, pairs, T_a_b, SurfaceTerm(a, b, T_a_b, flatness));
}

double surfaceError(const SurfaceVoxels& a, const SurfaceVoxels& b, const Pairs& pairs,
                    const Eigen::Isometry3d& T_a_b, double flatness) {
  return errorOf(b.surfaces.point, pairs, T_a_b, SurfaceTerm(a, b, T_a_b, flatness));
}

GradientScatter scatterSurfaces(const SurfaceVoxels& a, const SurfaceVoxels& b, const Pairs& pairs,
                                const Eigen::Isometry3d& T_a_b, double flatness,
                                const Eigen::Vector3d& centre, double side) {
  return scatterOf(b.surfaces.point, pairs, T_a_b, centre, side,
                   SurfaceTerm(a, b, T_a_b, flatness));
}

SimilarityEquations linearizeSimilarity(const SurfaceVoxels& a, const SurfaceVoxels& b,
                                        const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                                        double flatness, double side) {
  SimilarityEquations sum;
  if (pairs.empty()) return sum;
  const auto& points = b.surfaces.point;
  for (const Pair& p : pairs) sum.centre += T_a_b * points[p.b].cast<double>();
  sum.centre /= static_cast<double>(pairs.size());
  const SurfaceTerm term(a, b, T_a_b, flatness);
  std::map<Patch, SimilarityEquations::Vector7d> patches;
  for (const Pair& p : pairs) {
    const Eigen::Vector3d s = points[p.b].cast<double>(), q = T_a_b * s, r = q - sum.centre;
    const auto [e, weight] = term(p, q);
    const Eigen::Matrix3d W = matrixOf(weight);
    Eigen::Matrix<double, 3, 7> J;  // a step xi changes e to e - J xi
    J << Eigen::Matrix3d::Identity(), -skew(r), r;
    const Eigen::Vector3d We = W * e;
    const SimilarityEquations::Vector7d g = J.transpose() * We;
    sum.H += J.transpose() * W * J;
    sum.g += g;
    sum.error += e.dot(We);
    const auto found = patches.try_emplace(patchOf(s, side), SimilarityEquations::Vector7d::Zero());
    found.first->second += g;
  }
  sum.patches = patches.size();
  for (const auto& [place, g] : patches) sum.S += g * g.transpose();
  return sum;
}

}  // namespace mrpt::fusion
