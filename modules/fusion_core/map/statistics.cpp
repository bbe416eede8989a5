// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Computes counts and entropies of a map's leaves. */
#include <mrpt/fusion/voxels.h>
#include <octomap/octomap_utils.h>

#include <cmath>

#include "fusion_base/remembered_function.h"
#include "fusion_octree/walk.h"

namespace mrpt::fusion {

MapStatistics statisticsOf(const octomap::OcTree& map) {
  MapStatistics s;
  double entropy_occupied = 0, entropy_free = 0;
  RememberedFunction entropy(
      [](float log_odds) { return binaryEntropy(octomap::probability(log_odds)); });
  forEachLeaf(map, [&](const OcTreeCube& leaf, const auto& node) {
    const size_t side = leaf.side(), n = side * side * side;
    const double h = static_cast<double>(n) * entropy(node.getLogOdds());
    if (map.isNodeOccupied(node)) {
      s.occupied += n;
      entropy_occupied += h;
    } else {
      s.free += n;
      entropy_free += h;
    }
  });
  if (s.occupied) s.mean_entropy_occupied = entropy_occupied / static_cast<double>(s.occupied);
  if (s.occupied + s.free)
    s.mean_entropy_known =
        (entropy_occupied + entropy_free) / static_cast<double>(s.occupied + s.free);
  return s;
}

double binaryEntropy(double p) {
  if (p <= 0 || p >= 1) return 0;
  return -p * std::log(p) - (1 - p) * std::log1p(-p);
}

}  // namespace mrpt::fusion
