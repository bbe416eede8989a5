// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/voxel_blocks.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "kd_tree.h"
#include "parallel.h"

namespace mrpt::fusion {
namespace {

double radiusInVoxels(double radius, double min_voxels, double resolution) {
  return std::max(radius / resolution, min_voxels);
}

/** Blocks of voxels per task. */
constexpr size_t kBlockGrain = 64;

/** Calls `visit(i, neighbours)` for each voxel, see VoxelBlocks::forEachVoxel(), in parallel. */
template <class Visit>
void forEachVoxel(const VoxelBlocks& blocks, double radius, const Visit& visit) {
  const VoxelBlocks::Ball ball(radius);
  forEachIndex(blocks.size(), kBlockGrain,
               [&](size_t block) { blocks.forEachVoxel(block, ball, visit); });
}

/** Walks along the surface around one voxel (Algorithm 1, lines 9-16).
 *
 * A walk stays in the slice through the voxel that its normal and the walk's first direction span:
 * there the surface is a curve, and following it is a walk from voxel to voxel that may turn a
 * right angle (from a wall onto the floor) but not back. Lengths in voxels. */
class SurfaceTracer {
 public:
  explicit SurfaceTracer(double distance) : distance_(static_cast<float>(distance)) {}

  /** Goes to a voxel; \a neighbours are all that a walk from it can reach. */
  template <class Neighbours>
  void startFrom(const Neighbours& neighbours) {
    for (auto* axis : {&x_, &y_, &z_}) axis->clear();
    neighbours([&](uint32_t, const VoxelBlocks::Offset& o) {
      x_.push_back(static_cast<float>(o[0]));
      y_.push_back(static_cast<float>(o[1]));
      z_.push_back(static_cast<float>(o[2]));
    });
  }

  /** The angle between the vectors to the ends of the walks that leave the voxel along \a tangent
   * and against it, rad; none if the surface ends before d_T on a side. */
  std::optional<double> bend(const Eigen::Vector3f& tangent, const Eigen::Vector3f& normal) {
    cutSlice(tangent, normal);
    const auto t1 = trace({1, 0});
    if (!t1) return std::nullopt;
    const auto t2 = trace({-1, 0});
    if (!t2) return std::nullopt;
    return std::acos(std::clamp(static_cast<double>(t1->dot(*t2)), -1.0, 1.0));
  }

 private:
  static constexpr float kHalfSlice = 0.75F;  ///< slices this thick miss no voxel of a surface
  static constexpr float kMinStep = 0.5F;
  static constexpr float kMaxStep = 2.3F;      ///< across gaps of a sparsely seen surface
  static constexpr float kMinForward = -0.1F;  ///< cosine of the sharpest turn in one step

  /** The points near the plane that tangent and normal span, in its coordinates. */
  void cutSlice(const Eigen::Vector3f& tangent, const Eigen::Vector3f& normal) {
    const Eigen::Vector3f lateral = normal.cross(tangent);
    const size_t n = x_.size();
    cost_.resize(n);
    slice_.resize(n);
    along_.resize(n);
    above_.resize(n);
    const float *x = x_.data(), *y = y_.data(), *z = z_.data();
    float* const distance = cost_.data();
    const float lateral_x = lateral.x(), lateral_y = lateral.y(), lateral_z = lateral.z();
    for (size_t i = 0; i < n; i++)
      distance[i] = std::abs(x[i] * lateral_x + y[i] * lateral_y + z[i] * lateral_z);
    slice_size_ = 0;
    for (size_t i = 0; i < n; i++) {
      slice_[slice_size_] = static_cast<uint32_t>(i);
      slice_size_ += cost_[i] < kHalfSlice ? 1 : 0;
    }
    for (size_t k = 0; k < slice_size_; k++) {
      const Eigen::Vector3f p(x_[slice_[k]], y_[slice_[k]], z_[slice_[k]]);
      along_[k] = p.dot(tangent);
      above_[k] = p.dot(normal);
    }
  }

  /** TraceVectorAlongSurfaceVoxels: unit vector, in the slice, to where the walk is d_T away. */
  std::optional<Eigen::Vector2f> trace(Eigen::Vector2f direction) {
    Eigen::Vector2f at = Eigen::Vector2f::Zero();
    const int max_steps = 3 * static_cast<int>(distance_);
    for (int step = 0; step < max_steps; step++) {
      if (at.norm() >= distance_ - 0.5F) return middleOfSurfaceAt(at).normalized();
      const std::optional<Eigen::Vector2f> next = nextAfter(at, direction);
      if (!next) return std::nullopt;
      direction = (direction + 2 * (*next - at).normalized()).normalized();
      at = *next;
    }
    return std::nullopt;  // going round in a clutter of voxels
  }

  /** The voxel nearest to one step ahead, among those that a step reaches. */
  std::optional<Eigen::Vector2f> nextAfter(const Eigen::Vector2f& at,
                                           const Eigen::Vector2f& direction) {
    constexpr float kUnreachable = 1e9F;
    constexpr float kNearFirst = 1e-3F;  // of two as good, whatever their order
    // Without branches and through plain pointers, for the compiler to vectorise.
    const float *along = along_.data(), *above = above_.data();
    float* const cost = cost_.data();
    const float at_x = at.x(), at_y = at.y(), direction_x = direction.x(),
                direction_y = direction.y();
    for (size_t i = 0; i < slice_size_; i++) {
      const float x = along[i] - at_x, y = above[i] - at_y;
      const float length2 = x * x + y * y;
      const float forward = x * direction_x + y * direction_y;
      const float ahead_x = x - direction_x, ahead_y = y - direction_y;
      const float backward = forward < 0 ? forward : 0;
      const float ahead2 = ahead_x * ahead_x + ahead_y * ahead_y + kNearFirst * length2;
      const bool reachable = (length2 >= kMinStep * kMinStep) & (length2 <= kMaxStep * kMaxStep) &
                             (backward * backward <= kMinForward * kMinForward * length2);
      cost[i] = reachable ? ahead2 : kUnreachable;
    }
    size_t best = 0;
    float least = kUnreachable;
    for (size_t i = 0; i < slice_size_; i++)
      if (cost_[i] < least) {
        least = cost_[i];
        best = i;
      }
    if (least == kUnreachable) return std::nullopt;
    return Eigen::Vector2f(along_[best], above_[best]);
  }

  /** The mean of the voxels about a place: a single one tells the surface to half a voxel only,
   * which is 6 degrees of a walk of five. */
  Eigen::Vector2f middleOfSurfaceAt(const Eigen::Vector2f& place) const {
    constexpr float kRadius2 = 1.6F * 1.6F;
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    int n = 0;
    for (size_t i = 0; i < slice_size_; i++) {
      const Eigen::Vector2f q(along_[i], above_[i]);
      if ((q - place).squaredNorm() <= kRadius2) {
        sum += q;
        n++;
      }
    }
    return sum / static_cast<float>(n);
  }

  float distance_;
  std::vector<float> x_, y_, z_;      // all points, from the voxel
  std::vector<uint32_t> slice_;       // which of them are in the slice, the first slice_size_
  std::vector<float> along_, above_;  // of the slice's, by tangent and normal
  std::vector<float> cost_;
  size_t slice_size_ = 0;
};

/** Lines 9-20: whether the surface bends by an angle in the window at the tracer's voxel, in any
 * direction of its tangent plane. */
bool isBend(SurfaceTracer& tracer, const Eigen::Vector3f& normal, const EdgeParams& params) {
  const Eigen::Vector3f u = normal.unitOrthogonal();
  const Eigen::Vector3f v = normal.cross(u);
  const auto directions = std::lround(M_PI / params.trace_step_angle);
  for (long i = 0; i < directions; i++) {  // at theta = pi the pair of theta = 0 comes again
    const auto theta = static_cast<float>(M_PI * static_cast<double>(i) / directions);
    const auto angle = tracer.bend(std::cos(theta) * u + std::sin(theta) * v, normal);
    if (angle && *angle > params.alpha_min && *angle < params.alpha_max) return true;
  }
  return false;
}

/** Lines 2-6. */
Surfaces surfacesOf(const OccupiedVoxels& voxels, const VoxelBlocks& blocks,
                    const EdgeParams& params) {
  const double radius =
      radiusInVoxels(params.normal_radius, params.min_normal_radius_voxels, voxels.resolution);
  Surfaces surfaces;
  surfaces.normal.assign(voxels.size(), Eigen::Vector3f::Zero());
  surfaces.point = voxels.centre;
  forEachVoxel(blocks, radius, [&](uint32_t i, const auto& neighbours) {
    // Sums of whole numbers are exact, whatever their order.
    int n = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    neighbours([&](uint32_t, const VoxelBlocks::Offset& o) {
      n++;
      x += o[0];
      y += o[1];
      z += o[2];
      xx += o[0] * o[0];
      xy += o[0] * o[1];
      xz += o[0] * o[2];
      yy += o[1] * o[1];
      yz += o[1] * o[2];
      zz += o[2] * o[2];
    });
    const Eigen::Vector3d mean = Eigen::Vector3d(x, y, z) / n;
    Eigen::Matrix3d squares;
    squares << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    const Eigen::Matrix3d cov = squares / n - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> pca;
    pca.computeDirect(cov);
    const auto& spread = pca.eigenvalues();
    const bool has_plane =
        spread[1] > 1e-6 && spread[0] <= params.max_surface_variation * spread.sum();
    if (!has_plane) return;
    const Eigen::Vector3d normal = pca.eigenvectors().col(0);
    surfaces.normal[i] = normal.cast<float>();
    surfaces.point[i] += (voxels.resolution * normal.dot(mean) * normal).cast<float>();
  });
  return surfaces;
}

/** Eq. (5). */
std::vector<float> angleCostsOf(const OccupiedVoxels& voxels, const VoxelBlocks& blocks,
                                const std::vector<Eigen::Vector3f>& normals,
                                const EdgeParams& params) {
  const double radius =
      radiusInVoxels(params.cost_radius, params.min_cost_radius_voxels, voxels.resolution);
  std::vector<float> costs(voxels.size());
  forEachVoxel(blocks, radius, [&](uint32_t i, const auto& neighbours) {
    const Eigen::Vector3f normal = normals[i];
    float sum = 0;
    int n = 0;
    neighbours([&](uint32_t j, const VoxelBlocks::Offset&) {
      if (normals[j].isZero(0)) return;
      sum += normals[j].cross(normal).norm();
      n++;
    });
    costs[i] = n > 0 ? sum / static_cast<float>(n) : 0.F;
  });
  return costs;
}

/** Lines 7-22: whether each voxel is an edge. */
std::vector<uint8_t> detectEdges(const OccupiedVoxels& voxels, const VoxelBlocks& blocks,
                                 const std::vector<Eigen::Vector3f>& normals,
                                 const EdgeParams& params) {
  const auto costs = angleCostsOf(voxels, blocks, normals, params);
  const double distance = std::max(params.trace_distance / voxels.resolution, 4.0);
  const VoxelBlocks::Ball ball(distance + 2);
  std::vector<uint8_t> is_edge(voxels.size(), 0);
  forEachIndex(blocks.size(), kBlockGrain, [&](size_t block) {
    SurfaceTracer tracer(distance);
    blocks.forEachVoxel(block, ball, [&](uint32_t i, const auto& neighbours) {
      if (costs[i] <= params.kappa || normals[i].isZero(0)) return;
      tracer.startFrom(neighbours);
      is_edge[i] = isBend(tracer, normals[i], params);
    });
  });
  return is_edge;
}

/** Line 23: indices of the points whose mean distance to their nearest neighbours is not larger
 * than the mean of all plus so many standard deviations. */
std::vector<uint32_t> statisticalInliers(const std::vector<Eigen::Vector3f>& points,
                                         const EdgeParams& params) {
  std::vector<uint32_t> kept;
  const size_t k =
      std::min<size_t>(params.outlier_neighbours, points.empty() ? 0 : points.size() - 1);
  if (k == 0) return kept;
  const KdTree<3> tree(toDescriptors(points));
  std::vector<double> mean_distance(points.size());
  forEachIndex(points.size(), kGrain, [&](size_t i) {
    const auto neighbours = tree.nearest(tree.point(i), k + 1);  // the point itself is one
    double sum = 0;
    for (const float squared : neighbours.squared_distance) sum += std::sqrt(squared);
    mean_distance[i] = sum / static_cast<double>(k);
  });
  double mean = 0, squares = 0;
  for (const double d : mean_distance) {
    mean += d;
    squares += d * d;
  }
  const auto n = static_cast<double>(points.size());
  mean /= n;
  const double deviation = std::sqrt(std::max(0.0, squares / n - mean * mean));
  for (uint32_t i = 0; i < points.size(); i++)
    if (mean_distance[i] <= mean + params.outlier_deviations * deviation) kept.push_back(i);
  return kept;
}

/** Eq. (6) for each edge voxel, from the edge voxels around it. */
std::vector<EdgeCovariance> edgeCovariances(const std::vector<Eigen::Vector3f>& edges,
                                            double radius) {
  std::vector<EdgeCovariance> covariances(edges.size());
  if (edges.empty()) return covariances;
  const KdTree<3> tree(toDescriptors(edges));
  forEachIndex(edges.size(), kGrain, [&](size_t i) {
    std::vector<Eigen::Vector3f> neighbours;
    for (const uint32_t j : tree.within(tree.point(i), static_cast<float>(radius * radius)))
      neighbours.push_back(edges[j]);
    covariances[i] = edgeCovariance(neighbours);
  });
  return covariances;
}

}  // namespace

Surfaces computeSurfaces(const OccupiedVoxels& voxels, const EdgeParams& params) {
  return surfacesOf(voxels, VoxelBlocks(voxels.key), params);
}

std::vector<float> computeAngleCosts(const OccupiedVoxels& voxels,
                                     const std::vector<Eigen::Vector3f>& normals,
                                     const EdgeParams& params) {
  return angleCostsOf(voxels, VoxelBlocks(voxels.key), normals, params);
}

EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const EdgeParams& params) {
  return extractEdges(voxels, computeSurfaces(voxels, params).normal, params);
}

EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const std::vector<Eigen::Vector3f>& normals,
                        const EdgeParams& params) {
  const auto is_edge = detectEdges(voxels, VoxelBlocks(voxels.key), normals, params);

  std::vector<uint32_t> candidates;
  std::vector<Eigen::Vector3f> points;
  for (uint32_t i = 0; i < voxels.size(); i++)
    if (is_edge[i]) {
      candidates.push_back(i);
      points.push_back(voxels.centre[i]);
    }

  EdgeVoxels edges;
  edges.resolution = voxels.resolution;
  for (const uint32_t i : statisticalInliers(points, params)) {
    edges.centre.push_back(points[i]);
    edges.probability.push_back(voxels.probability[candidates[i]]);
  }
  // Just beyond the radius: whether a voxel at that very distance counts must not hang on rounding.
  edges.covariance =
      edgeCovariances(edges.centre, std::max(params.direction_radius, 3 * voxels.resolution) +
                                        1e-3 * voxels.resolution);
  return edges;
}

}  // namespace mrpt::fusion
