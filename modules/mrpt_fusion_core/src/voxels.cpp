// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/voxels.h>
#include <mrpt/maps/octree_voxels.h>
#include <mrpt/maps/remembered_function.h>

#include <algorithm>
#include <cmath>

namespace mrpt::fusion {
namespace {

template <class OnFree>
OccupiedVoxels extract(const octomap::OcTree& map, size_t max_voxels, OnFree&& on_free) {
  OccupiedVoxels voxels;
  voxels.resolution = map.getResolution();
  // More than most maps have, so that the arrays need not grow; what stays unused is not touched.
  const size_t enough = map.size() / 4;
  voxels.centre.reserve(enough);
  voxels.probability.reserve(enough);
  voxels.key.reserve(enough);
  mrpt::maps::forEachOccupiedVoxel(
      map, max_voxels,
      [&](const octomap::OcTreeKey& key, float probability) {
        voxels.centre.emplace_back(static_cast<float>(map.keyToCoord(key[0])),
                                   static_cast<float>(map.keyToCoord(key[1])),
                                   static_cast<float>(map.keyToCoord(key[2])));
        voxels.probability.push_back(probability);
        voxels.key.push_back(key);
      },
      on_free);
  return voxels;
}

}  // namespace

OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map, size_t max_voxels) {
  return extract(map, max_voxels, mrpt::maps::IgnoreCube());
}

OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map, FreeSpace& free,
                                     size_t max_voxels) {
  OccupiedVoxels voxels =
      extract(map, max_voxels, [&](const mrpt::maps::OcTreeCube& leaf) { free.add(leaf); });
  free.index();
  return voxels;
}

Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p.cast<double>();
  return sum / static_cast<double>(std::max<size_t>(1, points.size()));
}

size_t strideFor(size_t voxels, size_t enough) {
  return enough == 0 ? 1 : std::max<size_t>(1, (voxels + enough - 1) / enough);
}

MapStatistics statisticsOf(const octomap::OcTree& map) {
  MapStatistics s;
  double entropy_occupied = 0, entropy_free = 0;
  mrpt::maps::RememberedFunction entropy(
      [](float log_odds) { return binaryEntropy(octomap::probability(log_odds)); });
  mrpt::maps::forEachLeaf(map, [&](const mrpt::maps::OcTreeCube& leaf, const auto& node) {
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
