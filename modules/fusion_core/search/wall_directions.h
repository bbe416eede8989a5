// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/search_params.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "fusion_core/features/surfaces.h"

/** \file
 * The directions that walls and floors face. */

namespace mrpt::fusion {

/** Alignment of the walls of two maps over the yaw, from the headings of the normals. */
class WallDirections {
 public:
  WallDirections(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b,
                 const Eigen::Isometry3d& T_a_b, double share) {
    const Histogram of_a = histogram(a, Eigen::Matrix3d::Identity());
    const Histogram of_b = histogram(b, T_a_b.linear());
    for (int turn = 0; turn < kBins; turn++)
      for (int i = 0; i < kBins; i++)
        fit_[static_cast<size_t>(turn)] += of_a[wrapped(i + turn)] * of_b[static_cast<size_t>(i)];
    double mean = 0;
    for (const double f : fit_) {
      mean += f / kBins;
      best_ = std::max(best_, f);
    }
    least_ = mean + share * (best_ - mean);
  }

  /** True if a rotation of B by a yaw within half a step of \a yaw is plausible, rad. */
  bool arePlausible(double yaw, double step) const {
    const int middle = static_cast<int>(std::lround(yaw / kBin));
    const int half = static_cast<int>(std::ceil(0.5 * step / kBin));
    for (int i = middle - half; i <= middle + half; i++)
      if (fit_[wrapped(i)] >= least_) return true;
    return false;
  }

 private:
  static constexpr int kBins = 180;  ///< Bins of half a turn: normals have no sign
  static constexpr double kBin = M_PI / kBins;
  using Histogram = std::array<double, kBins>;

  static size_t wrapped(int bin) { return static_cast<size_t>((bin % kBins + kBins) % kBins); }

  static Histogram histogram(const std::vector<Eigen::Vector3f>& normals,
                             const Eigen::Matrix3d& R) {
    constexpr int kSpread = 2;  // deg: the normals of walls scatter
    Histogram h{};
    for (const Eigen::Vector3f& normal : normals) {
      const Eigen::Vector3d n = R * normal.cast<double>();
      const double upright = n.head<2>().norm();  // 1 on walls, 0 on floors and without a normal
      if (upright < 0.5) continue;
      const int bin = static_cast<int>(std::floor(std::atan2(n.y(), n.x()) / kBin));
      for (int d = -kSpread; d <= kSpread; d++) h[wrapped(bin + d)] += upright;
    }
    return h;
  }

  Histogram fit_{};
  double best_ = 0, least_ = 0;
};

/** Returns the directions that most surfaces face, largest surface first, at most \a most. They are
 * unit vectors; a direction and its opposite are the same. The least angle between two directions
 * is AllRotationsParams::apart. The least share of all surfaces that face a direction is
 * AllRotationsParams::min_share. */
std::vector<Eigen::Vector3d> dominantDirections(const Surfaces& surfaces, size_t most,
                                                const AllRotationsParams& params);

}  // namespace mrpt::fusion
