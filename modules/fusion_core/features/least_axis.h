// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

namespace mrpt::fusion {

/** The least eigenvalue of a positive semi-definite 3x3 matrix, and its eigenvector: a solver of
 * all three of each takes three times as long. */
class LeastAxis {
 public:
  explicit LeastAxis(const Eigen::Matrix3d& m) : m_(m), trace_(m.trace()) {
    minors_ = m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1) + m(0, 0) * m(2, 2) - m(0, 2) * m(0, 2) +
              m(1, 1) * m(2, 2) - m(1, 2) * m(1, 2);
    // Newton's iteration on x^3 - trace x^2 + minors x - det, whose roots are the eigenvalues: from
    // below it comes nearer to the first of them with each step, and never passes it but by
    // rounding, where it is a multiple one.
    constexpr int kMostSteps = 40;  // a third of the error stays each time if all are the same
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

  /** Whether both other eigenvalues are larger than so much. */
  bool othersExceed(double least) const {
    const double sum = trace_ - value_, product = minors_ - value_ * sum;
    return sum > 2 * least && (least - sum) * least + product > 0;
  }

  /** Unit vector, of arbitrary sign; any one if several fit. */
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
    // It is one of several: all are normal to the others' eigenvectors.
    const Eigen::Matrix3d others = m_ - value_ * Eigen::Matrix3d::Identity();
    if (!(others.colwise().squaredNorm().maxCoeff(&most) > 0)) return Eigen::Vector3d::UnitX();
    return others.col(most).unitOrthogonal();
  }

 private:
  Eigen::Matrix3d m_;
  double trace_, minors_, value_ = 0;
};

}  // namespace mrpt::fusion
