// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Looks points up in a map's voxels and free space. */
#include "fusion_core/map/occupancy_query.h"

namespace mrpt::fusion {

ObstacleCheck checkObstacle(const MapVoxels& map, const Eigen::Vector3d& p) {
  static const VoxelBlocks::Ball beside(1.8);  // a voxel and the 26 voxels around it
  octomap::OcTreeKey key;
  if (!map.map->coordToKeyChecked(p.x(), p.y(), p.z(), key)) return ObstacleCheck::Unknown;
  if (map.occupied.anyAround({key[0], key[1], key[2]}, beside)) return ObstacleCheck::Confirmed;
  if (map.has_free_space)
    return map.free.has(key) ? ObstacleCheck::Conflicting : ObstacleCheck::Unknown;
  static const VoxelBlocks::Ball near(4);  // voxels: surfaces around the place
  return map.occupied.anyAround({key[0], key[1], key[2]}, near) ? ObstacleCheck::Missed
                                                                : ObstacleCheck::Unknown;
}

bool isAtBorder(const MapVoxels& map, const Eigen::Vector3d& p) {
  const octomap::OcTreeKey key = map.map->coordToKey(p.x(), p.y(), p.z());
  for (unsigned axis = 0; axis < 3; axis++) {
    octomap::OcTreeKey before = key, behind = key;
    before[axis]--;
    behind[axis]++;
    if (map.free.has(before) != map.free.has(behind)) return true;
  }
  return false;
}

bool isFree(const MapVoxels& map, const Eigen::Vector3d& p) {
  octomap::OcTreeKey key;
  return map.map->coordToKeyChecked(p.x(), p.y(), p.z(), key) && map.free.has(key);
}

bool hasObstacle(const MapVoxels& map, const Eigen::Vector3d& p, const VoxelBlocks::Ball& ball) {
  octomap::OcTreeKey key;
  return map.map->coordToKeyChecked(p.x(), p.y(), p.z(), key) &&
         map.occupied.anyAround({key[0], key[1], key[2]}, ball);
}

}  // namespace mrpt::fusion
