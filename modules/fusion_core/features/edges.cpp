// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Implements Algorithm 1, lines 7-23, and eq. (6). */
#include "fusion_core/features/edges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "fusion_base/parallel.h"
#include "fusion_core/features/neighbourhoods.h"
#include "fusion_core/features/surface_moments.h"
#include "fusion_core/features/surface_tracer.h"
#include "fusion_core/features/uncertainty.h"
#include "fusion_core/map/kd_tree.h"
#include "fusion_core/map/voxel_blocks.h"

namespace mrpt::fusion {
namespace {

constexpr uint32_t kNone = ~uint32_t{0};

/** Returns eq. (5) for a voxel with a normal.
 * \param[in] near Index of the voxels with normals; includes the voxel itself.
 * \param[in] ball The neighbourhood.
 * \param[in] key Key of the voxel.
 * \param[in] normal Normal of the voxel.
 * \param[in] normals Normals of the voxels in \a near. */
float angleCost(const VoxelBlocks& near, const VoxelBlocks::Ball& ball,
                const octomap::OcTreeKey& key, const Eigen::Vector3f& normal,
                const std::vector<Eigen::Vector3f>& normals) {
  float sum = 0;
  int n = 0;
  near.forEachAround(placeOf(key), ball, [&](uint32_t j, const VoxelBlocks::Offset&) {
    const Eigen::Vector3f& other = normals[j];
    if (other.isZero(0)) return;
    sum += other.cross(normal).norm();
    n++;
  });
  return sum / static_cast<float>(n);
}

/** Returns the direction in a voxel's tangent plane in which the normals around it vary most, a
 * unit vector. If the voxel lies on an edge, this is the direction across the edge. */
Eigen::Vector3f acrossEdge(const VoxelBlocks& near, const VoxelBlocks::Ball& ball,
                           const octomap::OcTreeKey& key, const Eigen::Vector3f& normal,
                           const std::vector<Eigen::Vector3f>& normals) {
  Eigen::Vector3f u = normal.unitOrthogonal();
  const Eigen::Vector3f v = normal.cross(u);
  float uu = 0, uv = 0, vv = 0;
  near.forEachAround(placeOf(key), ball, [&](uint32_t j, const VoxelBlocks::Offset&) {
    const float a = normals[j].dot(u), b = normals[j].dot(v);
    uu += a * a;
    uv += a * b;
    vv += b * b;
  });
  // The larger principal axis of the 2x2 scatter, at half the angle of (uu - vv, 2 uv).
  const float x = uu - vv, y = 2 * uv, length = std::hypot(x, y);
  if (length == 0) return u;
  return x >= 0 ? ((length + x) * u + y * v).normalized()
                : (std::abs(y) * u + std::copysign(length - x, y) * v).normalized();
}

/** Returns the directions of the walks in the tangent plane, with x across the edge. Each direction
 * also represents its opposite. */
std::vector<Eigen::Vector2f> walkDirections(const EdgeParams& params) {
  std::vector<Eigen::Vector2f> directions;
  const auto add = [&](double angle) {
    directions.emplace_back(static_cast<float>(std::cos(angle)),
                            static_cast<float>(std::sin(angle)));
  };
  add(0);
  constexpr double kRightAngle = M_PI / 2, kRounding = 1e-9;
  double angle = params.trace_step_angle;
  for (; angle <= params.trace_window + kRounding && angle < kRightAngle - kRounding;
       angle += params.trace_step_angle) {
    add(angle);
    add(-angle);
  }
  add(kRightAngle);
  return directions;
}

/** Lines 10-20: true if the surface bends at the tracer's voxel by an angle in the angle window. */
bool isBend(SurfaceTracer& tracer, const std::vector<Eigen::Vector2f>& directions,
            const Eigen::Vector3f& normal, const Eigen::Vector3f& across,
            const EdgeParams& params) {
  const Eigen::Vector3f along = normal.cross(across);
  const auto bend = [&](const Eigen::Vector2f& d) {
    return tracer.bend(d.x() * across + d.y() * along, normal);
  };
  const auto isEdge = [&](const std::optional<float>& angle) {
    return angle && *angle > params.alpha_min && *angle < params.alpha_max;
  };
  const auto first = bend(directions.front());
  if (isEdge(first)) return true;
  const bool anywhere = params.trace_window >= M_PI / 2;
  if (!anywhere && !(first && *first > params.alpha_min - params.trace_beside &&
                     *first < params.alpha_max + params.trace_beside))
    return false;
  return std::any_of(directions.begin() + 1, directions.end(),
                     [&](const Eigen::Vector2f& d) { return isEdge(bend(d)); });
}

/** Lines 7-22: returns for each candidate the edge voxel among the voxels that the candidate
 * represents, or kNone. */
std::vector<uint32_t> detectEdges(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                                  const SurfaceVoxels& pieces,
                                  const std::vector<uint32_t>& candidates,
                                  const EdgeParams& params) {
  const Surfaces& surfaces = pieces.surfaces;
  const VoxelBlocks near(pieces.voxels.key);
  const VoxelBlocks::Ball cost_ball = costBall(params, voxels.resolution);
  const VoxelBlocks::Ball bend_ball = normalBall(params, voxels.resolution);
  const double distance = radiusInVoxels(params.trace_distance, 4, voxels.resolution);
  const auto directions = walkDirections(params);
  std::vector<uint32_t> first_of(pieces.voxels.size() + 1, 0);  // first voxel of each piece
  for (size_t k = 0; k < pieces.voxels.size(); k++)
    first_of[k + 1] = first_of[k] + static_cast<uint32_t>(surfaces.weight[k]);

  // The voxel of a piece where the surface bends most, and the normal there. The piece's own voxel
  // may lie beside the edge.
  const auto mostBent = [&](size_t k) {
    const uint32_t first = first_of[k], end = first_of[k + 1];
    std::pair best(first, surfaces.normal[k]);
    if (end == first + 1) return best;
    float most = -1;
    for (uint32_t i = first; i < end; i++) {
      const octomap::OcTreeKey& key = voxels.key[i];
      Plane here{surfaces.normal[k], surfaces.variation[k]};
      if (key != pieces.voxels.key[k]) here = surfaceAround(occupied, bend_ball, key, params);
      if (here.variation <= most) continue;
      most = here.variation;
      best = {i, here.normal};
    }
    return best;
  };

  std::vector<uint32_t> found(candidates.size(), kNone);
  forEachRange(found.size(), kGrain, [&](size_t begin, size_t end) {
    SurfaceTracer tracer(occupied, distance);
    for (size_t c = begin; c < end; c++) {
      const size_t k = candidates[c];
      if (surfaces.variation[k] < params.min_surface_variation) continue;
      const auto [i, normal] = mostBent(k);
      const octomap::OcTreeKey& key = voxels.key[i];
      if (normal.isZero(0) ||
          angleCost(near, cost_ball, key, normal, surfaces.normal) <= params.kappa)
        continue;
      tracer.moveTo(key);
      const Eigen::Vector3f u = acrossEdge(near, bend_ball, key, normal, surfaces.normal);
      if (isBend(tracer, directions, normal, u, params)) found[c] = i;
    }
  });
  return found;
}

/** Line 23: returns the indices of the points that are not outliers. The mean distance of an
 * outlier to its nearest neighbours is above the mean of all points plus
 * EdgeParams::outlier_deviations standard deviations. */
std::vector<uint32_t> statisticalInliers(const std::vector<Eigen::Vector3f>& points,
                                         const EdgeParams& params) {
  std::vector<uint32_t> kept;
  const size_t k =
      std::min<size_t>(params.outlier_neighbours, points.empty() ? 0 : points.size() - 1);
  if (k == 0) return kept;
  const KdTree<3> tree(toDescriptors(points));
  std::vector<double> mean_distance(points.size());
  forEachIndex(points.size(), kGrain, [&](size_t i) {
    const auto neighbours = tree.nearest(tree.point(i), k + 1);  // includes the point itself
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

/** Computes eq. (6) for each edge voxel from the edge voxels around it. */
std::vector<EdgeCovariance> edgeCovariances(const std::vector<octomap::OcTreeKey>& edges,
                                            double radius, double resolution) {
  const VoxelBlocks blocks(edges);
  // Slightly larger than the radius: a voxel at exactly this distance counts despite rounding.
  const VoxelBlocks::Ball ball(radius / resolution + 1e-3);
  std::vector<EdgeCovariance> covariances(edges.size());
  forEachIndex(edges.size(), kGrain, [&](size_t i) {
    const Moments moments = momentsAround(blocks, ball, edges[i]);
    covariances[i] = edgeCovariance(resolution * resolution * moments.covariance(), moments.size());
  });
  return covariances;
}

}  // namespace

std::vector<float> computeAngleCosts(const OccupiedVoxels& voxels,
                                     const std::vector<Eigen::Vector3f>& normals,
                                     const EdgeParams& params) {
  const VoxelBlocks blocks(voxels.key);
  const VoxelBlocks::Ball ball = costBall(params, voxels.resolution);
  std::vector<float> costs(voxels.size());
  forEachIndex(voxels.size(), kGrain, [&](size_t i) {
    if (!normals[i].isZero(0))
      costs[i] = angleCost(blocks, ball, voxels.key[i], normals[i], normals);
  });
  return costs;
}

EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const EdgeParams& params) {
  const VoxelBlocks occupied(voxels.key);
  std::vector<uint32_t> all(voxels.size());
  std::iota(all.begin(), all.end(), 0);
  return extractEdges(voxels, occupied, {voxels, computeSurfaces(voxels, occupied, params)}, all,
                      params);
}

EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                        const SurfaceVoxels& pieces, const std::vector<uint32_t>& candidates,
                        const EdgeParams& params) {
  std::vector<uint32_t> found = detectEdges(voxels, occupied, pieces, candidates, params);
  found.erase(std::remove(found.begin(), found.end(), kNone), found.end());
  std::vector<Eigen::Vector3f> points;
  points.reserve(found.size());
  for (const uint32_t i : found) points.push_back(voxels.centre[i]);

  std::vector<octomap::OcTreeKey> keys;
  std::vector<float> probability;
  for (const uint32_t i : statisticalInliers(points, params)) {
    keys.push_back(voxels.key[found[i]]);
    probability.push_back(voxels.probability[found[i]]);
  }
  return edgeVoxelsAt(keys, std::move(probability), octomap::OcTree(voxels.resolution),
                      params.direction_radius);
}

EdgeVoxels edgeVoxelsAt(const std::vector<octomap::OcTreeKey>& at, std::vector<float> probability,
                        const octomap::OcTree& grid, double direction_radius) {
  EdgeVoxels edges;
  edges.resolution = grid.getResolution();
  edges.direction_radius =
      std::clamp(direction_radius, 3 * edges.resolution, kMostVoxels * edges.resolution);
  edges.probability = std::move(probability);
  edges.centre.reserve(at.size());
  for (const auto& key : at) {
    const octomap::point3d p = grid.keyToCoord(key);
    edges.centre.emplace_back(p.x(), p.y(), p.z());
  }
  edges.covariance = edgeCovariances(at, edges.direction_radius, edges.resolution);
  return edges;
}

}  // namespace mrpt::fusion
