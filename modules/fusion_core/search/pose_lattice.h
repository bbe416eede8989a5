// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <tuple>
#include <vector>

#include "fusion_core/search/score_grid.h"

/** \file
 * The poses that a search tries: places of a lattice. */

namespace mrpt::fusion {

/** Range of translations of one yaw, in cells. */
struct Window {
  Cell low, size;

  size_t cells() const {
    return static_cast<size_t>(size[0]) * static_cast<size_t>(size[1]) *
           static_cast<size_t>(size[2]);
  }
};

/** A pose of a lattice with its score: yaw in steps, translation in cells. */
struct Place {
  float score;
  int yaw, x, y, z;

  int64_t farness() const {
    const auto square = [](int64_t v) { return v * v; };
    return square(yaw) + square(x) + square(y) + square(z);
  }
  bool isBetterThan(const Place& o) const {  // of equal scores the place near the guess
    if (score != o.score) return score > o.score;
    return std::make_tuple(farness(), yaw, x, y, z) <
           std::make_tuple(o.farness(), o.yaw, o.x, o.y, o.z);
  }
};

/** Test for places that lead to the same pose: distances in cells and steps of yaw. */
struct Near {
  int cells, yaws, turn;  // turn: steps of yaw in a full turn

  bool operator()(const Place& a, const Place& b) const {
    const int apart = std::abs(a.yaw - b.yaw);
    return std::abs(a.x - b.x) <= cells && std::abs(a.y - b.y) <= cells &&
           std::min(apart, std::abs(turn - apart)) <= yaws;
  }
};

/** The poses of a search: rotations by whole steps about an axis through a point, then
 * translations by whole cells. The cells and steps of each level are twice as wide as on the level
 * below. */
struct Lattice {
  Eigen::Isometry3d T_a_b;
  Eigen::Vector3d middle;  ///< Point on the axis of rotation, m, A's frame
  double cell, yaw_step;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< Direction of the axis, A's frame

  Lattice level(unsigned l) const {
    return {T_a_b, middle, std::ldexp(cell, static_cast<int>(l)),
            std::ldexp(yaw_step, static_cast<int>(l)), up};
  }
  Eigen::Isometry3d turned(int yaw) const {
    return Eigen::Isometry3d(Eigen::Translation3d(middle) * Eigen::AngleAxisd(yaw * yaw_step, up) *
                             Eigen::Translation3d(-middle) * T_a_b);
  }
  Eigen::Isometry3d at(const Place& p) const {
    return Eigen::Translation3d(p.x * cell, p.y * cell, p.z * cell) * turned(p.yaw);
  }
};

/** Returns the best places, best first. No place is near a better place. */
std::vector<Place> mostDistinct(std::vector<Place> places, size_t count, const Near& near);

}  // namespace mrpt::fusion
