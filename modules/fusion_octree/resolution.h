// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <stdexcept>

/** \file
 * The range of voxel sizes. */

namespace mrpt::fusion {

/** Limits of the voxel size of maps, of map definitions and of streams, m. */
constexpr double kMinResolution = 1e-4, kMaxResolution = 1e6;

/** Returns whether a voxel size is in the range. It is not if it is not a number. */
inline bool isResolution(double resolution) {
  return resolution >= kMinResolution && resolution <= kMaxResolution;
}

/** Checks a voxel size.
 * \exception std::runtime_error If it is out of range or not a number. */
inline void checkResolution(double resolution) {
  if (isResolution(resolution)) return;
  char text[80];
  std::snprintf(text, sizeof(text), "a voxel size of %g m is not in [%g, %g] m", resolution,
                kMinResolution, kMaxResolution);
  throw std::runtime_error(text);
}

}  // namespace mrpt::fusion
