// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * Conversion of real numbers to whole numbers. */

namespace mrpt::fusion {

/** Largest absolute result of toWhole(). Sums of a few results fit an int. */
constexpr int kMostWhole = 1 << 28;

/** Converts a number to int, towards zero. In contrast to a cast, numbers beyond kMostWhole, which
 * a far pose or a tiny voxel can cause, become kMostWhole or -kMostWhole. NaN becomes -kMostWhole.
 */
constexpr int toWhole(double x) {
  if (!(x > -kMostWhole)) return -kMostWhole;
  return x < kMostWhole ? static_cast<int>(x) : kMostWhole;
}

}  // namespace mrpt::fusion
