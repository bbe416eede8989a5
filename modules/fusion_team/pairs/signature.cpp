// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Computes what a map looks like, whatever its frame. */
#include "fusion_team/pairs/signature.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace mrpt::fusion {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr size_t kMostPlaces = 256;
constexpr double kRadius = 2;             // of a surrounding, m
constexpr size_t kLeastVoxels = 50;       // in a surrounding
constexpr double kLeastDistance = 0.05;   // of a voxel that counts, m
constexpr double kDamping = 0.5;          // m; near voxels are few, and each of them weighs more
constexpr Index kRings = 9, kAngles = 3;  // classes of the distance, and of each of two angles
constexpr Index kCounts = kRings * kAngles * kAngles;

/** Returns the class of the angle between two lines from its cosine: across, oblique, along. */
Index angleOf(double cosine) {
  constexpr double kOblique = 0.35, kAlong = 0.85;
  return (std::abs(cosine) >= kOblique ? 1 : 0) + (std::abs(cosine) >= kAlong ? 1 : 0);
}

/** Returns the column of a place; an empty vector with few voxels around.
 * \param[in] place,direction Position and direction of an edge, m. */
Eigen::VectorXf columnOf(const Vector3d& place, const Vector3d& direction, const SurfaceVoxels& map,
                         double scale) {
  Eigen::VectorXf counts = Eigen::VectorXf::Zero(kCounts);
  size_t n = 0;
  for (size_t i = 0; i < map.voxels.size(); i++) {
    const Vector3d offset = (map.voxels.centre[i].cast<double>() - place) / scale;
    const double distance = offset.norm();
    if (distance >= kRadius || distance <= kLeastDistance) continue;
    n++;
    // Each voxel is shared by two rings, so that small changes of a distance change little.
    const double ring = std::max(0.0, distance / kRadius * (kRings - 1) - 0.5);
    const double inner = std::floor(ring), weight = 1 / (distance + kDamping);
    const Index angles = kAngles * angleOf(direction.dot(map.surfaces.normal[i].cast<double>())) +
                         angleOf(direction.dot(offset) / distance);
    const Index first = static_cast<Index>(inner) * kAngles * kAngles + angles;
    counts[first] += static_cast<float>(weight * (1 - (ring - inner)));
    counts[first + kAngles * kAngles] += static_cast<float>(weight * (ring - inner));
  }
  if (n < kLeastVoxels) return {};
  return counts.cwiseSqrt().normalized();  // roots: large surfaces must not decide alone
}

}  // namespace

Signature signatureOf(const MapFeatures& map, double scale) {
  std::vector<Eigen::VectorXf> columns;
  const size_t stride = strideFor(map.edges.size(), kMostPlaces);
  for (size_t i = 0; i < map.edges.size(); i += stride) {
    Eigen::VectorXf column = columnOf(map.edges.centre[i].cast<double>(),
                                      map.edges.covariance[i].direction(), map.matched, scale);
    if (column.size() > 0) columns.push_back(std::move(column));
  }
  Signature signature(kCounts, static_cast<Index>(columns.size()));
  for (size_t i = 0; i < columns.size(); i++) signature.col(static_cast<Index>(i)) = columns[i];
  return signature;
}

}  // namespace mrpt::fusion
