// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/voxels.h>
#include <mrpt/maps/octree_build.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

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

/** Collects the occupied voxels below a tree's root (octomap's iterators keep a stack and compute
 * a key per node, free ones too: ten times the time). */
class OccupiedVoxelExtraction {
 public:
  OccupiedVoxelExtraction(const octomap::OcTree& map, size_t max_voxels)
      : map_(map), max_voxels_(max_voxels) {}

  OccupiedVoxels run() {
    voxels_.resolution = map_.getResolution();
    if (map_.getRoot()) visit(*map_.getRoot(), {});
    return std::move(voxels_);
  }

 private:
  void visit(const octomap::OcTreeNode& node, const mrpt::maps::OcTreeCube& cube) {
    if (map_.nodeHasChildren(&node)) {
      for (unsigned i = 0; i < 8; i++)
        if (map_.nodeChildExists(&node, i)) visit(*map_.getNodeChild(&node, i), cube.child(i));
    } else if (map_.isNodeOccupied(node)) {
      add(cube, static_cast<float>(node.getOccupancy()));
    }
  }

  void add(const mrpt::maps::OcTreeCube& cube, float probability) {
    const uint64_t volume = uint64_t{1} << (3 * (cube.kMaxDepth - cube.depth));
    if (volume > max_voxels_ || voxels_.size() + volume > max_voxels_)
      throw std::length_error("the map has more than " + std::to_string(max_voxels_) +
                              " occupied voxels");
    for (uint64_t i = 0; i < volume; i++) {
      const octomap::OcTreeKey key(
          static_cast<octomap::key_type>(cube.key[0] + everyThirdBit(i)),
          static_cast<octomap::key_type>(cube.key[1] + everyThirdBit(i >> 1)),
          static_cast<octomap::key_type>(cube.key[2] + everyThirdBit(i >> 2)));
      voxels_.centre.emplace_back(static_cast<float>(map_.keyToCoord(key[0])),
                                  static_cast<float>(map_.keyToCoord(key[1])),
                                  static_cast<float>(map_.keyToCoord(key[2])));
      voxels_.probability.push_back(probability);
      voxels_.key.push_back(key);
    }
  }

  const octomap::OcTree& map_;
  size_t max_voxels_;
  OccupiedVoxels voxels_;
};

}  // namespace

OccupiedVoxels extractOccupiedVoxels(const octomap::OcTree& map, size_t max_voxels) {
  return OccupiedVoxelExtraction(map, max_voxels).run();
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
