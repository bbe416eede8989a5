// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Computes the covariance of a pose from its normal equations. */
#include "fusion_core/registration/pose_covariance.h"

#include <algorithm>
#include <cmath>

#include "fusion_core/map/eigen_solvers.h"
#include "fusion_core/map/map_voxels.h"

namespace mrpt::fusion {

namespace {

/** Principal axes of a covariance, largest first. */
struct PrincipalAxes {
  Eigen::Vector3d deviation;  ///< Standard deviations
  Eigen::Matrix3d axes;       ///< Unit columns; the largest coordinate of each is positive

  explicit PrincipalAxes(const Eigen::Matrix3d& covariance) {
    const SymmetricEigen<3> solution(covariance);
    deviation = solution.eigenvalues.reverse().cwiseMax(0).cwiseSqrt();
    axes = solution.eigenvectors.rowwise().reverse();
    for (int i = 0; i < 3; i++) {
      int largest = 0;
      axes.col(i).cwiseAbs().maxCoeff(&largest);
      if (axes(largest, i) < 0) axes.col(i) *= -1;
    }
  }
  unsigned free() const {
    return static_cast<unsigned>((deviation.array() > kFreeDeviation).count());
  }
};

/** Returns the covariance of a point if the rotation is known. \a J is the Jacobian of the point.
 */
Eigen::Matrix3d atFixedRotation(const Matrix6d& covariance, const Eigen::Matrix<double, 3, 6>& J) {
  const Eigen::Matrix3d tr = J * covariance.rightCols<3>(),
                        rr = covariance.bottomRightCorner<3, 3>();
  return J * covariance * J.transpose() -
         tr * rr.completeOrthogonalDecomposition().pseudoInverse() * tr.transpose();
}

}  // namespace

PoseDeviation deviationAt(const Matrix6d& covariance, const Eigen::Vector3d& point) {
  Eigen::Matrix<double, 3, 6> J;  // Jacobian of the point
  J << Eigen::Matrix3d::Identity(), -skew(point);
  const PrincipalAxes of_point(J * covariance * J.transpose()),
      of_rotation(covariance.bottomRightCorner<3, 3>());
  PoseDeviation d{of_point.deviation[0], of_rotation.deviation[0], of_point.axes,
                  of_rotation.axes,      of_point.free(),          of_rotation.free()};
  if (d.free_axes > 0) {
    const PrincipalAxes alone(atFixedRotation(covariance, J));
    d.directions = alone.axes;
    d.free_directions = alone.free();
  }
  return d;
}

Matrix6d poseCovariance(const NormalEquations& at_optimum, size_t pairs,
                        const GradientScatter& scatter, double unknown_variance) {
  const double freedom = std::max(1.0, 3 * static_cast<double>(pairs) - 6);
  const double residual_variance = std::max(at_optimum.error / freedom, 1e-12);
  const SymmetricEigen<6> solution(at_optimum.H);
  const auto& V = solution.eigenvectors;
  Vector6d inverse = Vector6d::Zero(), unknown = Vector6d::Zero();
  int known = 0;
  for (int i = 0; i < 6; i++) {
    const double value = solution.eigenvalues[i];
    if (value > kNoInformation * solution.eigenvalues[5]) {
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

Matrix6d commonCovariance(const std::vector<Eigen::Vector3f>& points, double of_shift,
                          double of_bend, const Eigen::Vector3d& centre) {
  const Eigen::Vector3d middle = meanOf(points);
  double squares = 0;
  for (const auto& p : points) squares += (p.cast<double>() - middle).squaredNorm();
  // The entries of G are independent. They turn the map by half of the difference of two entries:
  // half of the variance of an entry.
  const double of_entry = of_bend * static_cast<double>(points.size()) / std::max(squares, of_bend);
  Matrix6d about_centre = of_shift * Matrix6d::Identity();
  about_centre.bottomRightCorner<3, 3>() = 0.5 * of_entry * Eigen::Matrix3d::Identity();
  const Matrix6d J = stepAbout(Eigen::Vector3d::Zero(), centre);
  return J * about_centre * J.transpose();
}

}  // namespace mrpt::fusion
