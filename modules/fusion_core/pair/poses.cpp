// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Converts poses and covariances, and derives search parameters from priors. */
#include <mrpt/core/exceptions.h>
#include <mrpt/core/format.h>
#include <mrpt/fusion/poses.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fusion_core/registration/normal_equations.h"

using namespace mrpt::fusion;
using mrpt::poses::CPose3D;

Eigen::Isometry3d mrpt::fusion::toEigen(const CPose3D& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = pose.getRotationMatrix().asEigen();
  T.translation() = Eigen::Vector3d(pose.x(), pose.y(), pose.z());
  return T;
}

CPose3D mrpt::fusion::toPose(const Eigen::Isometry3d& T) {
  return CPose3D(mrpt::math::CMatrixDouble44(Eigen::Matrix4d(T.matrix())));
}

Eigen::Isometry3d mrpt::fusion::toRigid(const Eigen::Matrix4d& matrix) {
  constexpr double kTolerance = 1e-3, kRounded = 1e-13;
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).norm();
  const bool is_rotation = error < kTolerance && R.determinant() > 0;
  const bool is_affine = (matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() < kTolerance;
  if (!is_rotation || !is_affine || !matrix.allFinite())
    throw std::runtime_error("the 4x4 matrix is not a rigid transform");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = matrix.topRightCorner<3, 1>();
  T.linear() = R;
  if (error < kRounded) return T;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  T.linear() = svd.matrixU() * svd.matrixV().transpose();
  return T;
}

namespace {

/** Returns the matrix W of a pose: changes of yaw, pitch and roll by d are the rotation W d. */
Eigen::Matrix3d rotationOfAngles(const Eigen::Isometry3d& T) {
  // R = Rz(yaw) Ry(pitch) Rx(roll), so a small rotation is
  // w = dyaw e_z + dpitch Rz e_y + droll Rz Ry e_x, and t moves by rho + w x t.
  const CPose3D pose = toPose(T);
  const Eigen::Matrix3d Rz = Eigen::AngleAxisd(pose.yaw(), Eigen::Vector3d::UnitZ()).matrix();
  const Eigen::Matrix3d Ry = Eigen::AngleAxisd(pose.pitch(), Eigen::Vector3d::UnitY()).matrix();
  Eigen::Matrix3d w_of_angles;
  w_of_angles << Eigen::Vector3d::UnitZ(), Rz.col(1), (Rz * Ry).col(0);
  return w_of_angles;
}

}  // namespace

Matrix6d mrpt::fusion::toYawPitchRollCovariance(const Matrix6d& covariance,
                                                const Eigen::Isometry3d& T) {
  const Eigen::Vector3d t = T.translation();
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.topRightCorner<3, 3>() = -skew(t);
  J.bottomRightCorner<3, 3>() = rotationOfAngles(T).inverse();
  return J * covariance * J.transpose();
}

Matrix6d mrpt::fusion::fromYawPitchRollCovariance(const Matrix6d& covariance,
                                                  const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d w_of_angles = rotationOfAngles(T);
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() = skew(T.translation()) * w_of_angles;
  J.bottomRightCorner<3, 3>() = w_of_angles;
  return J * covariance * J.transpose();
}

mrpt::poses::CPose3DPDFGaussian mrpt::fusion::noGuess() {
  mrpt::poses::CPose3DPDFGaussian prior;
  prior.cov.setDiagonal(6, kUnknownPoseSigma * kUnknownPoseSigma);
  return prior;
}

namespace {

void checkGuess(const CPose3D& guess) {
  const Eigen::Isometry3d T = toEigen(guess);
  ASSERTMSG_(T.matrix().allFinite(), "the initial guess is not a pose");
  const double farthest = T.translation().cwiseAbs().maxCoeff();
  ASSERTMSG_(farthest <= kMostCoordinate,
             mrpt::format("the initial guess is out of range: a coordinate of %g m", farthest));
}

}  // namespace

Prior Prior::none() { return {noGuess(), Checked()}; }

Prior Prior::near(const CPose3D& guess) {
  checkGuess(guess);
  return {mrpt::poses::CPose3DPDFGaussian(guess), Checked()};
}

Prior Prior::within(const CPose3D& guess, double position, double heading) {
  ASSERTMSG_(position > 0 && heading > 0,
             "a standard deviation of the initial guess is not above 0");
  mrpt::poses::CPose3DPDFGaussian pdf(guess);
  for (int i = 0; i < 3; i++) pdf.cov(i, i) = position * position;
  pdf.cov(3, 3) = heading * heading;
  return gaussian(pdf);
}

Prior Prior::gaussian(const mrpt::poses::CPose3DPDFGaussian& guess) {
  checkGuess(guess.mean);
  ASSERTMSG_(guess.cov.asEigen().allFinite() && guess.cov.asEigen().diagonal().minCoeff() >= 0,
             "the covariance of the initial guess is not finite or has a negative variance");
  return {guess, Checked()};
}

namespace {

/** Returns the largest standard deviation of a position in the x-y plane, m. */
double planeSigma(const mrpt::poses::CPose3DPDFGaussian& guess) {
  const auto& cov = guess.cov;
  const double half_sum = 0.5 * (cov(0, 0) + cov(1, 1));
  const double largest =
      half_sum + std::hypot(0.5 * (cov(0, 0) - cov(1, 1)), 0.5 * (cov(0, 1) + cov(1, 0)));
  return std::sqrt(largest);
}

}  // namespace

bool Prior::isNone() const { return kSearchSigmas * planeSigma(guess_) >= kUnknownPoseSigma; }

bool Prior::statesCovariance() const { return !guess_.cov.asEigen().isZero(0); }

SearchParams Prior::searchWithin(const SearchParams& configured) const {
  if (configured.translation <= 0 || !statesCovariance()) return configured;
  if (isNone()) return everywhere(configured);
  SearchParams search = configured;
  search.translation = std::max(kSearchSigmas * planeSigma(guess_), configured.cell);
  search.height = kSearchSigmas * std::sqrt(guess_.cov(2, 2));
  search.yaw = std::min(kSearchSigmas * std::sqrt(guess_.cov(3, 3)), M_PI);
  return search;
}
