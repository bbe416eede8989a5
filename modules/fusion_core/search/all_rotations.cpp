// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Aligns directions of B with the direction that most of A's surfaces face, and searches. */
#include "fusion_core/search/all_rotations.h"

#include <cmath>
#include <memory>
#include <utility>

#include "fusion_core/map/eigen_solvers.h"
#include "fusion_core/search/wall_directions.h"
#include "fusion_octree/resampling.h"

namespace mrpt::fusion {

std::vector<Hypothesis> searchAllRotations(const MapVoxels& a, const Surfaces& surfaces_a,
                                           const SurfaceVoxels& b, const SearchParams& params) {
  const AllRotationsParams& rotations = params.all_rotations;
  const double upright = std::cos(rotations.upright);
  const auto facing_a = dominantDirections(surfaces_a, 1, rotations);
  const auto facing_b = dominantDirections(b.surfaces, rotations.directions, rotations);
  if (facing_a.empty()) return {};

  // A is turned so that searchAround() rotates about A's dominant direction.
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  Eigen::Isometry3d T_turned_a = Eigen::Isometry3d::Identity();
  MapVoxels turned;
  Surfaces turned_surfaces;
  const bool is_upright = std::abs(facing_a[0].dot(z)) > upright;
  if (!is_upright) {
    T_turned_a.linear() = rotationBetween(facing_a[0], z);
    turned = MapVoxels(transformOcTree(*a.map, T_turned_a, a.map->getResolution()));
    turned_surfaces = surfaces_a;
    for (auto& n : turned_surfaces.normal) n = T_turned_a.linear().cast<float>() * n;
  }

  std::vector<Hypothesis> all;
  for (const auto& direction : facing_b)
    for (const double sign : {1.0, -1.0}) {
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.linear() = rotationBetween(sign * direction, T_turned_a.linear() * facing_a[0]);
      auto found = is_upright ? searchAround(a, surfaces_a, b, T, params)
                              : searchAround(turned, turned_surfaces, b, T, params);
      for (Hypothesis& h : found) h.T_a_b = T_turned_a.inverse() * h.T_a_b;
      all.insert(all.end(), found.begin(), found.end());
    }
  return bestOf(std::move(all), params);
}

}  // namespace mrpt::fusion
