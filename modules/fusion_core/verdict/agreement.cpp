// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Counts confirmed obstacles and conflicts at a pose. */
#include "fusion_core/verdict/agreement.h"

#include <algorithm>
#include <cmath>

#include "fusion_core/map/occupancy_query.h"

namespace mrpt::fusion {
namespace {

/** Numbers of the other map's obstacles that a map confirms, and that lie in its free space. */
struct ObstacleCounts {
  double confirmed = 0, contradicted = 0;
};

ObstacleCounts countObstacles(const MapVoxels& map, const Obstacles& obstacles, double resolution,
                              const Eigen::Isometry3d& T, const AgreementParams& params,
                              const BorderParams& border) {
  const double before = params.front_voxels * std::max(resolution, map.voxels.resolution);
  ObstacleCounts counts;
  for (size_t i = 0; i < obstacles.centre.size(); i++) {
    const Eigen::Vector3d centre = obstacles.centre[i].cast<double>();
    const Eigen::Vector3d place = T * centre;
    const ObstacleCheck check = checkObstacle(map, place);
    if (check == ObstacleCheck::Confirmed) {
      const Eigen::Vector3d front = obstacles.front[i].cast<double>();
      const bool same_side = front.isZero(0) || isFree(map, T * (centre + before * front));
      counts.confirmed += same_side ? 1 : params.other_side;
    } else if (check == ObstacleCheck::Conflicting) {
      counts.contradicted += conflictWeight(map, place, border);
    } else if (check == ObstacleCheck::Missed) {
      counts.contradicted += params.missed;
    }
  }
  return counts;
}

}  // namespace

ObstacleCheck checkFromSameSide(const MapVoxels& map, const Obstacles& obstacles, size_t i,
                                double before, const Eigen::Isometry3d& T) {
  const Eigen::Vector3d centre = obstacles.centre[i].cast<double>();
  const ObstacleCheck check = checkObstacle(map, T * centre);
  if (check != ObstacleCheck::Confirmed) return check;
  const Eigen::Vector3d front = obstacles.front[i].cast<double>();
  return front.isZero(0) || isFree(map, T * (centre + before * front)) ? ObstacleCheck::Confirmed
                                                                       : ObstacleCheck::Unknown;
}

Obstacles obstaclesOf(const MapVoxels& map, const SurfaceVoxels& voxels,
                      const AgreementParams& params) {
  Obstacles obstacles{voxels.voxels.centre, voxels.surfaces.normal};
  const double before = params.front_voxels * voxels.voxels.resolution;
  for (size_t i = 0; i < obstacles.centre.size(); i++) {
    Eigen::Vector3f& front = obstacles.front[i];
    const Eigen::Vector3d centre = obstacles.centre[i].cast<double>();
    const Eigen::Vector3d step = before * front.cast<double>();
    const bool ahead = isFree(map, centre + step), behind = isFree(map, centre - step);
    if (ahead == behind)
      front.setZero();
    else if (behind)
      front = -front;
  }
  return obstacles;
}

size_t confirmedFromSameSide(const MapVoxels& a, const Obstacles& of_a, const MapVoxels& b,
                             const Obstacles& of_b, const Eigen::Isometry3d& T_a_b,
                             const AgreementParams& params) {
  const double before = params.front_voxels * std::max(a.voxels.resolution, b.voxels.resolution);
  const auto count = [&](const MapVoxels& map, const Obstacles& obstacles,
                         const Eigen::Isometry3d& T) {
    size_t confirmed = 0;
    for (size_t i = 0; i < obstacles.centre.size(); i++)
      if (checkFromSameSide(map, obstacles, i, before, T) == ObstacleCheck::Confirmed) confirmed++;
    return confirmed;
  };
  return count(a, of_b, T_a_b) + count(b, of_a, T_a_b.inverse());
}

double conflictWeight(const MapVoxels& map, const Eigen::Vector3d& p, const BorderParams& border) {
  return map.voxels.resolution <= border.largest_voxel && isAtBorder(map, p) ? border.weight : 1;
}

double agreement(const MapVoxels& a, const Obstacles& of_a, const MapVoxels& b,
                 const Obstacles& of_b, const Eigen::Isometry3d& T_a_b,
                 const AgreementParams& params, const BorderParams& border) {
  const ObstacleCounts by_a = countObstacles(a, of_b, b.voxels.resolution, T_a_b, params, border);
  const ObstacleCounts by_b =
      countObstacles(b, of_a, a.voxels.resolution, T_a_b.inverse(), params, border);
  const double confirmed = by_a.confirmed + by_b.confirmed;
  const double contradicted = by_a.contradicted + by_b.contradicted;
  if (confirmed == 0) return 0;
  return confirmed * std::exp(-contradicted / (confirmed + contradicted) / params.tolerance);
}

}  // namespace mrpt::fusion
