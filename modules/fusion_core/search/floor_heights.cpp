// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Correlates the heights of two maps' obstacles. */
#include "fusion_core/search/floor_heights.h"

#include <algorithm>
#include <cstddef>

#include "fusion_base/whole_number.h"

namespace mrpt::fusion {

std::optional<FloorAlignment> alignFloors(const std::vector<double>& layers_a, int low_a,
                                          const std::vector<double>& layers_b, int low_b,
                                          double step, double most, double share) {
  const int reach = toWhole(std::min(most / step, 1e6));
  const int first = std::max(-reach, low_a - low_b - static_cast<int>(layers_b.size()));
  std::vector<double> fit;
  for (int s = first; s <= std::min(reach, low_a - low_b + static_cast<int>(layers_a.size()));
       s++) {
    fit.push_back(0);
    for (size_t k = 0; k < layers_b.size(); k++) {
      const int layer = static_cast<int>(k) + low_b + s - low_a;
      if (layer >= 0 && layer < static_cast<int>(layers_a.size()))
        fit.back() += layers_b[k] * layers_a[static_cast<size_t>(layer)];
    }
  }
  const auto best = std::max_element(fit.begin(), fit.end());
  if (best == fit.end() || *best == 0) return std::nullopt;
  const auto isGood = [&](double f) { return f >= share * *best; };
  const auto lowest = std::find_if(fit.begin(), best, isGood);
  const auto highest = std::find_if(fit.rbegin(), fit.rend(), isGood);
  const auto shift = static_cast<double>(first + (best - fit.begin()));
  return FloorAlignment{shift * step,
                        {step * static_cast<double>(lowest - best),
                         step * static_cast<double>(highest.base() - 1 - best)}};
}

}  // namespace mrpt::fusion
