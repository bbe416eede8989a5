// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Bounds the cost of the covariances of edge voxels. */

#include "mrpt_fusion_maps/edge_cost.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace mrpt::fusion {

uint64_t edgePairs(const std::vector<octomap::OcTreeKey>& edges, double radius) {
  // Cells as large as the radius: all edge voxels within the radius are in 27 cells.
  const auto side = static_cast<unsigned>(std::ceil(std::max(1.0, radius)));
  using Counts = std::unordered_map<octomap::OcTreeKey, uint64_t, octomap::OcTreeKey::KeyHash>;
  Counts counts;
  const auto part = [&](octomap::key_type k, unsigned offset) {
    return static_cast<octomap::key_type>(k / side + offset);
  };
  for (const auto& e : edges) counts[{part(e[0], 1), part(e[1], 1), part(e[2], 1)}]++;

  uint64_t pairs = 0;
  for (const auto& entry : counts)
    for (unsigned i = 0; i < 27; i++) {
      const auto beside = [&](unsigned axis, unsigned third) {
        return static_cast<octomap::key_type>(entry.first[axis] + third % 3 - 1);
      };
      const auto near = counts.find({beside(0, i), beside(1, i / 3), beside(2, i / 9)});
      if (near != counts.end()) pairs += entry.second * near->second;
    }
  return pairs;
}

}  // namespace mrpt::fusion
