// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/voxels.h>
#include <mrpt/maps/octree_voxels.h>

#include <algorithm>
#include <cmath>

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
  OccupiedVoxels voxels;
  voxels.resolution = map.getResolution();
  mrpt::maps::forEachOccupiedVoxel(
      map, max_voxels, [&](const octomap::OcTreeKey& key, float probability) {
        voxels.centre.emplace_back(static_cast<float>(map.keyToCoord(key[0])),
                                   static_cast<float>(map.keyToCoord(key[1])),
                                   static_cast<float>(map.keyToCoord(key[2])));
        voxels.probability.push_back(probability);
        voxels.key.push_back(key);
      });
  return voxels;
}

Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p.cast<double>();
  return sum / static_cast<double>(std::max<size_t>(1, points.size()));
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
