// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Computes the covariances of voxels and edges, eqs. (4)-(9). */
#include "fusion_core/features/uncertainty.h"

#include <algorithm>

#include "fusion_core/map/eigen_solvers.h"

namespace mrpt::fusion {

double voxelVariance(double probability, double resolution, VoxelCovariance kind) {
  const double unit = kind == VoxelCovariance::Plain ? 1.0 : resolution * resolution / 12;
  return unit / std::max(probability, 1e-6);
}

double EdgeCovariance::linearity() const {
  const double sum = eigenvalues.sum();
  return sum > 0 ? eigenvalues[2] / sum : 1.0 / 3;
}

Eigen::Matrix3d EdgeCovariance::matrix(double floor_variance) const {
  return eigenvectors * (eigenvalues.array() + floor_variance).matrix().asDiagonal() *
         eigenvectors.transpose();
}

EdgeCovariance edgeCovariance(const Eigen::Matrix3d& covariance, size_t neighbours) {
  EdgeCovariance result;
  if (neighbours < 3 || covariance.trace() <= 0) {
    result.eigenvalues.setConstant(covariance.trace() / 3);
    return result;
  }
  const SymmetricEigen<3> solution(covariance);
  result.eigenvalues = solution.eigenvalues.cwiseMax(0);
  result.eigenvectors = solution.eigenvectors;
  return result;
}

EdgeCovariance edgeCovariance(const std::vector<Eigen::Vector3f>& neighbours) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : neighbours) mean += p.cast<double>();
  const auto n = static_cast<double>(std::max<size_t>(1, neighbours.size()));
  mean /= n;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& p : neighbours) {
    const Eigen::Vector3d d = p.cast<double>() - mean;
    covariance += d * d.transpose();
  }
  return edgeCovariance(covariance / n, neighbours.size());
}

Eigen::Matrix3d fuseCovariances(double voxel_variance, const Eigen::Matrix3d& edge) {
  // (I/v + E^-1)^-1 = v (E + vI)^-1 E, which also holds for a singular E.
  const Eigen::Matrix3d sum = edge + voxel_variance * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d product = voxel_variance * sum.inverse() * edge;
  return 0.5 * (product + product.transpose());
}

}  // namespace mrpt::fusion
