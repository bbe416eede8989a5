// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

/** \file
 * Least eigenvalue of a 3x3 matrix. */

namespace mrpt::fusion {

/** The least eigenvalue of a positive semi-definite 3x3 matrix, and its eigenvector. A solver of
 * all eigenvalues and eigenvectors takes 3 times as long. */
class LeastAxis {
 public:
  explicit LeastAxis(const Eigen::Matrix3d& m) : m_(m), trace_(m.trace()) {
    minors_ = m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1) + m(0, 0) * m(2, 2) - m(0, 2) * m(0, 2) +
              m(1, 1) * m(2, 2) - m(1, 2) * m(1, 2);
    // Newton's iteration on x^3 - trace x^2 + minors x - det, whose roots are the eigenvalues. It
    // starts below the least root and approaches it with each step. It can pass the root only by
    // rounding, at a multiple root.
    constexpr int kMostSteps = 40;  // a triple root: each step leaves at most 2/3 of the error
    constexpr double kExact = 1e-7, kFlat = 1e-12;
    const double det = m.determinant();
    for (int step = 0; step < kMostSteps; step++) {
      const double slope = (3 * value_ - 2 * trace_) * value_ + minors_;
      if (!(slope > kFlat * trace_ * trace_)) break;
      const double residual = ((value_ - trace_) * value_ + minors_) * value_ - det;
      const double last = value_;
      value_ = std::min(last - residual / slope, trace_ / 3);
      if (!(value_ - last > kExact * trace_)) break;
    }
    value_ = std::max(value_, 0.0);
  }

  double value() const { return value_; }
  double trace() const { return trace_; }

  /** True if both other eigenvalues are larger than \a least. */
  bool othersExceed(double least) const {
    const double sum = trace_ - value_, product = minors_ - value_ * sum;
    return sum > 2 * least && (least - sum) * least + product > 0;
  }

  /** Returns the eigenvector, a unit vector of arbitrary sign. For a multiple eigenvalue it is any
   * of the eigenvectors. */
  Eigen::Vector3d direction() const {
    // The adjugate of m - value I is a multiple of n n'.
    const double xx = m_(0, 0) - value_, yy = m_(1, 1) - value_, zz = m_(2, 2) - value_;
    const double xy = m_(0, 1), xz = m_(0, 2), yz = m_(1, 2);
    const double a = xz * yz - xy * zz, b = xy * yz - xz * yy, c = xy * xz - yz * xx;
    Eigen::Matrix3d adjugate;
    adjugate << yy * zz - yz * yz, a, b, a, xx * zz - xz * xz, c, b, c, xx * yy - xy * xy;
    Eigen::Index most;
    constexpr double kNothing = 1e-12;
    if (adjugate.diagonal().maxCoeff(&most) > kNothing * trace_ * trace_)
      return adjugate.col(most).normalized();
    // A multiple eigenvalue: all its eigenvectors are normal to the other eigenvectors.
    const Eigen::Matrix3d others = m_ - value_ * Eigen::Matrix3d::Identity();
    if (!(others.colwise().squaredNorm().maxCoeff(&most) > 0)) return Eigen::Vector3d::UnitX();
    return others.col(most).unitOrthogonal();
  }

 private:
  Eigen::Matrix3d m_;
  double trace_, minors_, value_ = 0;
};

}  // namespace mrpt::fusion
