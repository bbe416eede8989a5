// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/voxels.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace mrpt::fusion {
namespace {

/** Finest voxels along the side of a leaf, and in all of it. */
template <class Leaf>
uint32_t sideOf(const octomap::OcTree& map, const Leaf& leaf) {
  return 1U << (map.getTreeDepth() - leaf.getDepth());
}
template <class Leaf>
size_t volumeOf(const octomap::OcTree& map, const Leaf& leaf) {
  const size_t side = sideOf(map, leaf);
  return side * side * side;
}

}  // namespace

OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map, size_t max_voxels) {
  size_t count = 0;
  for (auto it = map.begin_leafs(); it != map.end_leafs(); ++it) {
    if (!map.isNodeOccupied(*it)) continue;
    const size_t n = volumeOf(map, it);
    if (n > max_voxels || count + n > max_voxels)
      throw std::length_error("the map has more than " + std::to_string(max_voxels) +
                              " occupied voxels");
    count += n;
  }

  OccupiedVoxels v;
  v.resolution = map.getResolution();
  v.centre.reserve(count);
  v.probability.reserve(count);
  v.key.reserve(count);
  for (auto it = map.begin_leafs(); it != map.end_leafs(); ++it) {
    if (!map.isNodeOccupied(*it)) continue;
    const octomap::OcTreeKey low = it.getIndexKey();
    const uint32_t side = sideOf(map, it);
    const auto p = static_cast<float>(it->getOccupancy());
    for (uint32_t x = 0; x < side; x++)
      for (uint32_t y = 0; y < side; y++)
        for (uint32_t z = 0; z < side; z++) {
          const octomap::OcTreeKey key(static_cast<octomap::key_type>(low[0] + x),
                                       static_cast<octomap::key_type>(low[1] + y),
                                       static_cast<octomap::key_type>(low[2] + z));
          v.centre.emplace_back(static_cast<float>(map.keyToCoord(key[0])),
                                static_cast<float>(map.keyToCoord(key[1])),
                                static_cast<float>(map.keyToCoord(key[2])));
          v.probability.push_back(p);
          v.key.push_back(key);
        }
  }
  return v;
}

MapStatistics statisticsOf(const octomap::OcTree& map) {
  MapStatistics s;
  double entropy_occupied = 0, entropy_free = 0;
  for (auto it = map.begin_leafs(); it != map.end_leafs(); ++it) {
    const size_t n = volumeOf(map, it);
    const double h = static_cast<double>(n) * binaryEntropy(it->getOccupancy());
    if (map.isNodeOccupied(*it)) {
      s.occupied += n;
      entropy_occupied += h;
    } else {
      s.free += n;
      entropy_free += h;
    }
  }
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
