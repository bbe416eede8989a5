// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <vector>

/** \file
 * At which height floors of one map lie on floors of another. */

namespace mrpt::fusion {

/** Heights that lay floors on floors. */
struct FloorAlignment {
  double shift;  ///< Best shift of B along z, m
  std::array<double, 2>
      plausible;  ///< Lowest and highest shift that may be right, from \a shift, m
};

/** Compares the heights of obstacles, in layers, at all shifts of B along z.
 * \param[in] layers_a,layers_b Number of obstacles in each layer; the first layer is number \a
 * low_a or \a low_b, counted from z = 0. \param[in] step Height of a layer, m. \param[in] most
 * Largest shift either way, m. \param[in] share Least alignment of a plausible shift, as a share of
 * the best: floors on other storeys' floors are plausible, floors on ceilings are not. \return None
 * if the maps share no height. O(shifts * layers). */
std::optional<FloorAlignment> alignFloors(const std::vector<double>& layers_a, int low_a,
                                          const std::vector<double>& layers_b, int low_b,
                                          double step, double most, double share);

}  // namespace mrpt::fusion
