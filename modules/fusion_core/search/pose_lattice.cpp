// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Chooses the best places of a lattice. */
#include "fusion_core/search/pose_lattice.h"

#include <algorithm>
#include <iterator>

namespace mrpt::fusion {

std::vector<Place> mostDistinct(std::vector<Place> places, size_t count, const Near& near) {
  const auto better = [](const Place& a, const Place& b) { return a.isBetterThan(b); };
  std::vector<Place> best;
  auto sorted = places.begin();
  for (size_t next = 64 * count; best.size() < count && sorted != places.end(); next *= 4) {
    const auto end =
        sorted + std::min(static_cast<std::ptrdiff_t>(next), std::distance(sorted, places.end()));
    std::nth_element(sorted, end - 1, places.end(), better);
    std::sort(sorted, end, better);
    for (; sorted != end && best.size() < count; sorted++)
      if (std::none_of(best.begin(), best.end(), [&](const Place& b) { return near(*sorted, b); }))
        best.push_back(*sorted);
    sorted = end;
  }
  return best;
}

}  // namespace mrpt::fusion
