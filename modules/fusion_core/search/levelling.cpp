// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Turns B such that its ground lies along A's ground, and searches. */
#include "fusion_core/search/levelling.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <utility>

#include "fusion_core/map/eigen_solvers.h"

namespace mrpt::fusion {
namespace {

constexpr double kLeastClearShare = 0.1;  // least score of a place that stands out, per voxel of B
constexpr double kSlopeDifference = 0.044;  // rad (2.5 deg), of the grounds of both maps
constexpr unsigned kTurns = 6;              // number of directions of that difference

/** Returns the score of the best hypothesis; 0 without hypotheses. */
double bestScore(const std::vector<Hypothesis>& best_first) {
  return best_first.empty() ? 0 : best_first[0].score;
}

/** Returns the horizontal distance of B's voxels from their mean that 90 % do not exceed, m. */
double radiusOf(const OccupiedVoxels& voxels) {
  const Eigen::Vector3d middle = meanOf(voxels.centre);
  std::vector<double> distances(voxels.size());
  std::transform(voxels.centre.begin(), voxels.centre.end(), distances.begin(), [&](const auto& p) {
    return (p.template cast<double>() - middle).template head<2>().norm();
  });
  const auto far = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() * 9 / 10);
  std::nth_element(distances.begin(), far, distances.end());
  return *far;
}

/** A voxel of the ground, in the column of its block. */
struct GroundVoxel {
  int x, y;        ///< Block
  uint16_t z;      ///< Key of the voxel
  uint32_t voxel;  ///< Index of the voxel

  bool operator<(const GroundVoxel& o) const {
    return std::tie(x, y, z, voxel) < std::tie(o.x, o.y, o.z, o.voxel);
  }
  /** True if the voxel lies on the layer of the next lower voxel. */
  bool isInLayerOf(const GroundVoxel& below) const {
    constexpr int kGap = 2;  // voxels
    return x == below.x && y == below.y && z - below.z <= kGap;
  }
};

/** Returns the voxels whose surface faces up or down, ordered by block and height. */
std::vector<GroundVoxel> groundOf(const SurfaceVoxels& map, const LevellingParams& params) {
  const auto least = static_cast<float>(std::cos(params.max_tilt));
  const int side = static_cast<int>(params.block_voxels);
  std::vector<GroundVoxel> ground;
  for (uint32_t i = 0; i < map.voxels.size(); i++)
    if (std::abs(map.surfaces.normal[i].z()) > least) {
      const auto& key = map.voxels.key[i];
      ground.push_back({key[0] / side, key[1] / side, key[2], i});
    }
  std::sort(ground.begin(), ground.end());
  return ground;
}

/** Slope of a layer: the rise along x and y, and the number of its voxels. */
struct Slope {
  std::array<double, 2> rise;
  double weight;
};

/** Returns the slope of the plane z = c + rise_x x + rise_y y through a layer; nothing if the layer
 * is small or no plane. */
std::optional<Slope> slopeOf(const OccupiedVoxels& voxels,
                             std::vector<GroundVoxel>::const_iterator first,
                             std::vector<GroundVoxel>::const_iterator last,
                             const LevellingParams& params) {
  const auto n = static_cast<double>(last - first);
  const double side = params.block_voxels * voxels.resolution;
  if (n < params.min_layer_voxels) return {};
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (auto g = first; g != last; g++) mean += voxels.centre[g->voxel].cast<double>() / n;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (auto g = first; g != last; g++) {
    const Eigen::Vector3d d = voxels.centre[g->voxel].cast<double>() - mean;
    scatter += d * d.transpose() / n;
  }
  // A strip has no slope across it: a layer must be wide in its narrow direction, too. A whole
  // block has a variance of 1/12 of its squared side.
  constexpr double kLeastVariance = 0.02;
  const Eigen::Matrix2d plan = scatter.topLeftCorner<2, 2>();
  const double narrow = SymmetricEigen<2>(plan).eigenvalues[0];
  if (narrow < kLeastVariance * side * side) return {};
  const Eigen::Vector2d rise = plan.ldlt().solve(scatter.topRightCorner<2, 1>());
  const double residual = scatter(2, 2) - rise.dot(scatter.topRightCorner<2, 1>());
  if (residual > voxels.resolution * voxels.resolution) return {};  // no plane within a voxel
  return Slope{{rise.x(), rise.y()}, n};
}

/** Returns the weighted median of the rise along an axis. */
double medianOf(std::vector<Slope> slopes, size_t axis) {
  std::sort(slopes.begin(), slopes.end(),
            [&](const Slope& s, const Slope& t) { return s.rise[axis] < t.rise[axis]; });
  double all = 0, below = 0;
  for (const Slope& s : slopes) all += s.weight;
  for (const Slope& s : slopes) {
    below += s.weight;
    if (2 * below >= all) return s.rise[axis];
  }
  return 0;
}

}  // namespace

Eigen::Vector3d upDirection(const SurfaceVoxels& map, const LevellingParams& params) {
  std::vector<Slope> slopes;
  const std::vector<GroundVoxel> ground = groundOf(map, params);
  for (auto first = ground.begin(); first != ground.end();) {
    auto last = first + 1;
    while (last != ground.end() && last->isInLayerOf(*(last - 1))) last++;
    if (const auto slope = slopeOf(map.voxels, first, last, params)) slopes.push_back(*slope);
    first = last;
  }
  if (slopes.empty()) return Eigen::Vector3d::UnitZ();
  return Eigen::Vector3d(-medianOf(slopes, 0), -medianOf(slopes, 1), 1).normalized();
}

std::vector<Hypothesis> searchLevelled(const MapVoxels& a, const SurfaceVoxels& matched_a,
                                       const SurfaceVoxels& matched_b, const SurfaceVoxels& few_b,
                                       const Eigen::Isometry3d& T_a_b, const SearchParams& params) {
  auto all = searchAround(a, matched_a.surfaces, few_b, T_a_b, params);
  if (few_b.voxels.size() == 0) return all;
  const Eigen::Vector3d up_a = upDirection(matched_a, params.levelling);
  const Eigen::Vector3d up_b = T_a_b.linear() * upDirection(matched_b, params.levelling);
  const double cell = leastCell(params, a.voxels.resolution, few_b.voxels.resolution);
  const double tilt = std::acos(std::clamp(up_a.dot(up_b), -1.0, 1.0));
  if (tilt * radiusOf(few_b.voxels) <= params.levelling.max_cells * cell) return all;
  const auto searchTurned = [&](const Eigen::Vector3d& up) {
    Eigen::Isometry3d levelled = T_a_b;
    levelled.linear() = rotationBetween(up, up_a) * T_a_b.linear();
    return searchAround(a, matched_a.surfaces, few_b, levelled, params, up_a);
  };
  auto found = searchTurned(up_b);
  // The grounds of two parts of a hillside differ in slope. If no place stands out, B is turned by
  // such a difference in all directions.
  const double clear = kLeastClearShare * static_cast<double>(few_b.voxels.size());
  for (unsigned k = 0; k < kTurns && std::max(bestScore(all), bestScore(found)) < clear; k++) {
    const double angle = 2 * M_PI * k / kTurns;
    const Eigen::Vector3d slope(std::cos(angle), std::sin(angle), 0);
    auto turned = searchTurned((up_b + kSlopeDifference * slope).normalized());
    if (bestScore(turned) > bestScore(found)) found = std::move(turned);
  }
  // A levelling that does not help would only add rivals.
  if (bestScore(found) <= bestScore(all)) return all;
  all.insert(all.end(), found.begin(), found.end());
  return bestOf(std::move(all), params);
}

}  // namespace mrpt::fusion
