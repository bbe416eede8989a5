// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/voxel_index.h>

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

/** The voxels around a place of the grid. */
struct Neighbourhood {
  const OccupiedVoxels& voxels;
  const VoxelIndex& index;
  const std::vector<VoxelIndex::Offset> offsets;

  template <class F>
  void forEach(uint32_t i, F&& f) const {
    const auto& k = voxels.key[i];
    for (const auto& o : offsets) {
      const uint32_t j = index.find(k[0] + o[0], k[1] + o[1], k[2] + o[2]);
      if (j != VoxelIndex::kNone) f(j, o);
    }
  }
};

Surfaces surfacesOf(const Neighbourhood& around, const EdgeParams& params) {
  Surfaces surfaces;
  surfaces.normal.assign(around.voxels.size(), Eigen::Vector3f::Zero());
  surfaces.point = around.voxels.centre;
  forEachIndex(around.voxels.size(), kGrain, [&](size_t i) {
    // On the integer grid, so that the sums are exact.
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    int n = 0;
    around.forEach(static_cast<uint32_t>(i), [&](uint32_t, const VoxelIndex::Offset& o) {
      const Eigen::Vector3d d(o[0], o[1], o[2]);
      sum += d;
      squares += d * d.transpose();
      n++;
    });
    const Eigen::Vector3d mean = sum / n;
    const Eigen::Matrix3d cov = squares / n - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> pca;
    pca.computeDirect(cov);
    const auto& spread = pca.eigenvalues();
    const bool has_plane =
        spread[1] > 1e-6 && spread[0] <= params.max_surface_variation * spread.sum();
    if (!has_plane) return;
    const Eigen::Vector3d normal = pca.eigenvectors().col(0);
    surfaces.normal[i] = normal.cast<float>();
    surfaces.point[i] += (around.voxels.resolution * normal.dot(mean) * normal).cast<float>();
  });
  return surfaces;
}

std::vector<float> angleCostsOf(const Neighbourhood& around,
                                const std::vector<Eigen::Vector3f>& normals) {
  std::vector<float> costs(normals.size());
  forEachIndex(costs.size(), kGrain, [&](size_t i) {
    float sum = 0;
    int n = 0;
    around.forEach(static_cast<uint32_t>(i), [&](uint32_t j, const VoxelIndex::Offset&) {
      if (normals[j].isZero()) return;
      sum += normals[j].cross(normals[i]).norm();
      n++;
    });
    costs[i] = n > 0 ? sum / static_cast<float>(n) : 0.F;
  });
  return costs;
}

/** Walks along the surface around one voxel (Algorithm 1, lines 9-16).
 *
 * A walk stays in the slice through the voxel that its normal and the walk's first direction span:
 * there the surface is a curve, and following it is a walk from voxel to voxel that may turn a
 * right angle (from a wall onto the floor) but not back. Lengths in voxels. */
class SurfaceTracer {
 public:
  SurfaceTracer(const Neighbourhood& around, uint32_t voxel, double distance)
      : distance_(static_cast<float>(distance)) {
    around.forEach(voxel, [&](uint32_t, const VoxelIndex::Offset& o) {
      points_.emplace_back(static_cast<float>(o[0]), static_cast<float>(o[1]),
                           static_cast<float>(o[2]));
    });
  }

  /** The angle between the vectors to the ends of the walks that leave the voxel along \a tangent
   * and against it, rad; none if the surface ends before d_T on a side. */
  std::optional<double> bend(const Eigen::Vector3f& tangent, const Eigen::Vector3f& normal) {
    const Eigen::Vector3f lateral = normal.cross(tangent);
    slice_.clear();
    for (const auto& p : points_)
      if (std::abs(p.dot(lateral)) < kHalfSlice) slice_.emplace_back(p.dot(tangent), p.dot(normal));
    const auto t1 = trace({1, 0});
    if (!t1) return std::nullopt;
    const auto t2 = trace({-1, 0});
    if (!t2) return std::nullopt;
    return std::acos(std::clamp(static_cast<double>(t1->dot(*t2)), -1.0, 1.0));
  }

 private:
  static constexpr float kHalfSlice = 0.75F;   ///< slices this thick miss no voxel of a surface
  static constexpr float kMaxStep = 2.3F;      ///< across gaps of a sparsely seen surface
  static constexpr float kMinForward = -0.1F;  ///< cosine of the sharpest turn in one step

  /** TraceVectorAlongSurfaceVoxels: unit vector, in the slice, to where the walk is d_T away. */
  std::optional<Eigen::Vector2f> trace(Eigen::Vector2f direction) const {
    Eigen::Vector2f at = Eigen::Vector2f::Zero();
    const int max_steps = 3 * static_cast<int>(distance_);
    for (int step = 0; step < max_steps; step++) {
      if (at.norm() >= distance_ - 0.5F) return middleOfSurfaceAt(at).normalized();
      const Eigen::Vector2f ahead = at + direction;
      const Eigen::Vector2f* next = nullptr;
      float nearest = std::numeric_limits<float>::max();
      for (const auto& q : slice_) {
        const Eigen::Vector2f move = q - at;
        const float length = move.norm();
        if (length < 0.5F || length > kMaxStep || move.dot(direction) < kMinForward * length)
          continue;
        const float d = (q - ahead).squaredNorm();
        if (d < nearest) {
          nearest = d;
          next = &q;
        }
      }
      if (!next) return std::nullopt;
      direction = (direction + 2 * (*next - at).normalized()).normalized();
      at = *next;
    }
    return std::nullopt;  // going round in a clutter of voxels
  }

  /** The mean of the voxels about a place: a single one tells the surface to half a voxel only,
   * which is 6 degrees of a walk of five. */
  Eigen::Vector2f middleOfSurfaceAt(const Eigen::Vector2f& place) const {
    constexpr float kRadius2 = 1.6F * 1.6F;
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    int n = 0;
    for (const auto& q : slice_)
      if ((q - place).squaredNorm() <= kRadius2) {
        sum += q;
        n++;
      }
    return sum / static_cast<float>(n);
  }

  float distance_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<Eigen::Vector2f> slice_;
};

/** Lines 9-20: whether the surface bends by an angle in the window at a voxel, in any direction of
 * its tangent plane. */
bool isBend(const Neighbourhood& around, uint32_t voxel, const Eigen::Vector3f& normal,
            double distance, const EdgeParams& params) {
  if (normal.isZero()) return false;
  SurfaceTracer tracer(around, voxel, distance);
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

Neighbourhood neighbourhood(const OccupiedVoxels& voxels, const VoxelIndex& index, double radius,
                            double min_voxels) {
  return {voxels, index,
          VoxelIndex::offsetsWithin(radiusInVoxels(radius, min_voxels, voxels.resolution))};
}

}  // namespace

Surfaces computeSurfaces(const OccupiedVoxels& voxels, const EdgeParams& params) {
  const VoxelIndex index(voxels.key);
  return surfacesOf(
      neighbourhood(voxels, index, params.normal_radius, params.min_normal_radius_voxels), params);
}

std::vector<float> computeAngleCosts(const OccupiedVoxels& voxels,
                                     const std::vector<Eigen::Vector3f>& normals,
                                     const EdgeParams& params) {
  const VoxelIndex index(voxels.key);
  return angleCostsOf(
      neighbourhood(voxels, index, params.cost_radius, params.min_cost_radius_voxels), normals);
}

EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const EdgeParams& params) {
  return extractEdges(voxels, computeSurfaces(voxels, params).normal, params);
}

EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const std::vector<Eigen::Vector3f>& normals,
                        const EdgeParams& params) {
  const auto costs = computeAngleCosts(voxels, normals, params);

  const VoxelIndex index(voxels.key);
  const double distance = std::max(params.trace_distance / voxels.resolution, 4.0);
  const Neighbourhood around{voxels, index, VoxelIndex::offsetsWithin(distance + 2)};
  std::vector<uint8_t> is_edge(voxels.size(), 0);
  forEachIndex(voxels.size(), kGrain, [&](size_t i) {
    if (costs[i] > params.kappa)
      is_edge[i] = isBend(around, static_cast<uint32_t>(i), normals[i], distance, params);
  });

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
