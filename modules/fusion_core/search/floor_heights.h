// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <vector>

/** \file
 * The height at which floors of one map lie on floors of another map. */

namespace mrpt::fusion {

/** Shifts along z that lay floors on floors. */
struct FloorAlignment {
  double shift;                     ///< Best shift of B along z, m
  std::array<double, 2> plausible;  ///< Lowest and highest plausible shift, relative to \a shift, m
};

/** Compares the heights of obstacles, in layers, at all shifts of B along z.
 * Cost: O(shifts * layers).
 * \param[in] layers_a,layers_b Number of obstacles in each layer.
 * \param[in] low_a,low_b Number of the first layer, counted from z = 0.
 * \param[in] step Height of a layer, m.
 * \param[in] most Largest shift up or down, m.
 * \param[in] share Least alignment of a plausible shift, as a share of the best alignment. Floors
 * on floors of other storeys are plausible, floors on ceilings are not.
 * \return Nothing if the maps share no height. */
std::optional<FloorAlignment> alignFloors(const std::vector<double>& layers_a, int low_a,
                                          const std::vector<double>& layers_b, int low_b,
                                          double step, double most, double share);

}  // namespace mrpt::fusion
