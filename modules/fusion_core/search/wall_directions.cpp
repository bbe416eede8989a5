// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Finds the directions that most surfaces face. */
#include "fusion_core/search/wall_directions.h"

#include <algorithm>
#include <cmath>

#include "fusion_core/map/eigen_solvers.h"
#include "fusion_core/map/map_voxels.h"

namespace mrpt::fusion {

std::vector<Eigen::Vector3d> dominantDirections(const Surfaces& surfaces, size_t most,
                                                const AllRotationsParams& params) {
  const double alike = std::cos(params.alike), apart = std::cos(params.apart);
  std::vector<Eigen::Vector3d> normals;  // normals times the square root of their weights
  const size_t stride = strideFor(surfaces.normal.size(), params.sample_surfaces);
  for (size_t i = 0; i < surfaces.normal.size(); i += stride)
    if (!surfaces.normal[i].isZero())
      normals.emplace_back(std::sqrt(surfaces.weight[i]) * surfaces.normal[i].cast<double>());
  double all = 0;
  for (const auto& n : normals) all += n.squaredNorm();

  const auto face = [](const Eigen::Vector3d& n, const Eigen::Vector3d& direction, double cosine) {
    return std::abs(n.dot(direction)) > cosine * n.norm();
  };
  std::vector<Eigen::Vector3d> directions;
  while (directions.size() < most) {
    double of_best = params.min_share * all;
    Eigen::Vector3d best = Eigen::Vector3d::Zero();
    for (const auto& candidate : normals) {
      double sum = 0;
      for (const auto& n : normals)
        if (face(n, candidate.normalized(), alike)) sum += n.squaredNorm();
      if (sum > of_best) {
        of_best = sum;
        best = candidate.normalized();
      }
    }
    if (best.isZero()) break;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const auto& n : normals)
      if (face(n, best, alike)) scatter += n * n.transpose();
    directions.emplace_back(SymmetricEigen<3>(scatter).eigenvectors.col(2));
    normals.erase(std::remove_if(normals.begin(), normals.end(),
                                 [&](const auto& n) { return face(n, directions.back(), apart); }),
                  normals.end());
  }
  return directions;
}

}  // namespace mrpt::fusion
