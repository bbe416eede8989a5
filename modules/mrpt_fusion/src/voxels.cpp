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

/** One coordinate of the i-th voxel of a cube in the octree's order, x fastest at each depth. */
uint32_t everyThirdBit(uint64_t i) {
  uint32_t bits = 0;
  for (unsigned bit = 0; i >> (3 * bit); bit++)
    bits |= static_cast<uint32_t>(i >> (3 * bit) & 1) << bit;
  return bits;
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
    const uint64_t volume = uint64_t{side} * side * side;
    for (uint64_t i = 0; i < volume; i++) {
      const octomap::OcTreeKey key(static_cast<octomap::key_type>(low[0] + everyThirdBit(i)),
                                   static_cast<octomap::key_type>(low[1] + everyThirdBit(i >> 1)),
                                   static_cast<octomap::key_type>(low[2] + everyThirdBit(i >> 2)));
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
