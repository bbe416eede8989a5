// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Compares the occupied voxels of a map with the free space of other maps. */

#include "fusion_report/page/conflicts.h"

#include <algorithm>
#include <cstdint>

#include "fusion_base/parallel.h"
#include "fusion_octree/walk.h"

namespace mrpt::fusion {
namespace {

/** True if a map knows a point (m, map frame) as free and has no occupied voxel around it. */
bool isInFreeSpace(const octomap::OcTree& map, const Eigen::Vector3d& p) {
  octomap::OcTreeKey key;
  const octomap::point3d point(static_cast<float>(p.x()), static_cast<float>(p.y()),
                               static_cast<float>(p.z()));
  if (!keyAt(map, point, key)) return false;
  const auto* here = map.search(key);
  if (!here || map.isNodeOccupied(here)) return false;
  for (int i = 0; i < 27; i++) {
    octomap::OcTreeKey beside = key;
    const int step[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
    bool is_inside = true;
    for (unsigned axis = 0; axis < 3; axis++) {
      const int at = key[axis] + step[axis];
      is_inside = is_inside && at >= 0 && at <= 0xffff;
      beside[axis] = static_cast<octomap::key_type>(at);
    }
    const auto* node = is_inside ? map.search(beside) : nullptr;
    if (node && map.isNodeOccupied(node)) return false;
  }
  return true;
}

/** Divides cubes into their voxels; cubes of more than 64 voxels into 64 cubes. */
std::vector<PageCube> divided(const std::vector<PageCube>& cubes) {
  std::vector<PageCube> parts;
  parts.reserve(cubes.size());
  for (const PageCube& c : cubes) {
    const unsigned depth = std::min(c.cube.depth + 2, OcTreeCube::kMaxDepth);
    const unsigned levels = depth - c.cube.depth;
    for (uint64_t i = 0; i < uint64_t{1} << (3 * levels); i++) {
      PageCube part = c;
      for (unsigned level = levels; level-- > 0;)
        part.cube = part.cube.child(static_cast<unsigned>(i >> (3 * level) & 7U));
      parts.push_back(part);
    }
  }
  return parts;
}

}  // namespace

PageCubes conflictingCubes(const octomap::OcTree& map, const std::vector<OtherMap>& others) {
  const PageCubes occupied = occupiedCubes(map);
  const std::vector<PageCube> parts = divided(occupied.cubes);
  std::vector<uint8_t> conflicts(parts.size(), 0);
  const double half_grid = 1U << (OcTreeCube::kMaxDepth - 1);
  forEachIndex(parts.size(), kGrain, [&](size_t i) {
    const OcTreeCube& cube = parts[i].cube;
    const Eigen::Vector3d key(cube.key[0], cube.key[1], cube.key[2]);
    const Eigen::Vector3d centre =
        (key.array() + 0.5 * cube.side() - half_grid).matrix() * occupied.resolution;
    conflicts[i] = std::any_of(others.begin(), others.end(), [&](const OtherMap& other) {
      return isInFreeSpace(*other.map, other.T_other_this * centre);
    });
  });
  PageCubes result{occupied.resolution, {}};
  for (size_t i = 0; i < parts.size(); i++)
    if (conflicts[i]) result.cubes.push_back(parts[i]);
  return result;
}

}  // namespace mrpt::fusion
