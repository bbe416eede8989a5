// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Writes ratios as text. */
#include "fusion_base/percent_text.h"

#include <cstdio>

namespace mrpt::fusion {
namespace {

std::string textOf(double ratio, int decimals) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.*f %%", decimals, 100 * ratio);
  return text;
}

}  // namespace

std::string percent(double ratio) { return textOf(ratio, 1); }

std::string percentBeside(double limit, double ratio) {
  constexpr int kMostDecimals = 4;
  if (ratio == limit) return percent(ratio);
  int decimals = 1;
  while (decimals < kMostDecimals && textOf(ratio, decimals) == textOf(limit, decimals)) decimals++;
  return textOf(ratio, decimals);
}

}  // namespace mrpt::fusion
