// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CProbOctoMap: insertion of observations, points and voxels, likelihood of observations, and rays.
 */

#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationStereoImages.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "fusion_link/map_replica.h"
#include "fusion_octree/insertion/scan_insertion.h"
#include "fusion_octree/walk.h"
#include "mrpt_fusion_maps/map_diffs.h"

using namespace mrpt::maps;
using namespace mrpt::obs;
using mrpt::fusion::InnerNodes;

namespace {

/** The points of an observation and the position of the sensor, both in the map's frame. */
struct Rays {
  explicit Rays(double resolution) : reach(resolution * (1 << 30)) {}

  /** True for a point whose voxel OctoMap can compute: it counts voxels by int and does not check.
   * Other points are far outside of the map, or not numbers. */
  bool canHold(double x, double y, double z) const {
    return std::abs(x) < reach && std::abs(y) < reach && std::abs(z) < reach;
  }

  double reach;  // m
  octomap::point3d origin;
  std::vector<octomap::point3d> ends;
};

void addPoint(const mrpt::poses::CPose3D& frame, float p_x, float p_y, float p_z, Rays& rays) {
  double x = 0, y = 0, z = 0;
  frame.composePoint(p_x, p_y, p_z, x, y, z);
  if (rays.canHold(x, y, z))
    rays.ends.emplace_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
}

void addPoints(const mrpt::poses::CPose3D& frame, const CPointsMap& points, Rays& rays) {
  rays.ends.reserve(points.size());
  for (size_t i = 0; i < points.size(); i++) {
    float x = 0, y = 0, z = 0;
    points.getPointFast(i, x, y, z);
    addPoint(frame, x, y, z, rays);
  }
}

/** Returns the rays of an observation. \return Nothing if the observation has no points, is of a
 * kind that cannot be inserted, or was made too far away, see Rays::canHold(). */
std::optional<Rays> raysOf(const CObservation& obs, const mrpt::poses::CPose3D& robot,
                           double resolution) {
  // The observation may be lazy-loaded. Pictures are not needed, and their files may be missing.
  if (!IS_DERIVED(obs, CObservationImage) && !IS_DERIVED(obs, CObservationStereoImages)) obs.load();
  mrpt::poses::CPose3D sensor_on_robot;
  obs.getSensorPose(sensor_on_robot);
  const mrpt::poses::CPose3D sensor = robot + sensor_on_robot;
  Rays rays(resolution);
  if (!rays.canHold(sensor.x(), sensor.y(), sensor.z())) return std::nullopt;
  rays.origin = octomap::point3d(static_cast<float>(sensor.x()), static_cast<float>(sensor.y()),
                                 static_cast<float>(sensor.z()));

  if (const auto* scan2d = dynamic_cast<const CObservation2DRangeScan*>(&obs)) {
    // These points are in the frame of the robot.
    addPoints(robot, *scan2d->buildAuxPointsMap<CPointsMap>(), rays);
  } else if (const auto* scan3d = dynamic_cast<const CObservation3DRangeScan*>(&obs)) {
    if (scan3d->hasPoints3D) {
      const size_t n = scan3d->points3D_x.size();
      rays.ends.reserve(n);
      for (size_t i = 0; i < n; i++) {
        const float x = scan3d->points3D_x[i], y = scan3d->points3D_y[i], z = scan3d->points3D_z[i];
        if (x != 0 || y != 0 || z != 0) addPoint(sensor, x, y, z, rays);  // (0,0,0): no echo
      }
    } else if (scan3d->hasRangeImage) {
      CObservation3DRangeScan copy(*scan3d);  // unprojectInto() is not const
      CSimplePointsMap points;
      copy.unprojectInto(points);
      addPoints(sensor, points, rays);
    } else {
      return std::nullopt;
    }
  } else if (const auto* velodyne = dynamic_cast<const CObservationVelodyneScan*>(&obs)) {
    const auto add = [&](const CObservationVelodyneScan::TPointCloud& cloud) {
      rays.ends.reserve(cloud.x.size());
      for (size_t i = 0; i < cloud.x.size(); i++)
        addPoint(sensor, cloud.x[i], cloud.y[i], cloud.z[i], rays);
    };
    if (velodyne->point_cloud.x.empty()) {
      CObservationVelodyneScan copy(*velodyne);  // generatePointCloud() is not const
      copy.generatePointCloud();
      add(copy.point_cloud);
    } else {
      add(velodyne->point_cloud);
    }
  } else if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&obs)) {
    if (!cloud->pointcloud) return std::nullopt;
    addPoints(sensor, *cloud->pointcloud, rays);
  } else {
    return std::nullopt;
  }
  return rays;
}

}  // namespace

void CProbOctoMap::insertScan(const std::vector<octomap::point3d>& ends,
                              const octomap::point3d& origin) {
  applySensorModel();
  const auto known = static_cast<InnerNodes>(m_tree_state.innerNodes());
  m_tree_state.setInnerNodes(static_cast<uint8_t>(mrpt::fusion::insertScan(
      *m_octree, ends, origin, insertionOptions.maxrange, insertionOptions.pruning, known)));
}

bool CProbOctoMap::insert(const CObservation& obs, const mrpt::poses::CPose3D& robot) {
  if (const auto* diff = dynamic_cast<const CObservationMapDiff*>(&obs)) return insertDiff(*diff);
  const auto rays = raysOf(obs, robot, getResolution());
  if (!rays) return false;
  insertScan(rays->ends, rays->origin);
  return true;
}

bool CProbOctoMap::internal_insertObservation(
    const CObservation& obs, const std::optional<const mrpt::poses::CPose3D>& robotPose) {
  if (!insert(obs, robotPose.value_or(mrpt::poses::CPose3D()))) return false;
  publish();
  return true;
}

bool CProbOctoMap::insertDiff(const CObservationMapDiff& diff) {
  const bool is_of_robot = m_robot_map && m_robot_map->source().robot == diff.sensorLabel;
  if (!is_of_robot && (m_robot_map || !isEmpty())) return false;
  auto known = std::make_shared<mrpt::fusion::MapReplica>(
      m_robot_map ? *m_robot_map : mrpt::fusion::emptyReplicaOf(diff));
  mrpt::fusion::addDiff(diff, *known);
  const bool is_new = known->completeVersion() > 0;
  if (is_new) setOctree(mrpt::fusion::joinBlocks(*known->blocks()));
  m_robot_map = std::move(known);
  return is_new;
}

void CProbOctoMap::insertPointCloud(const CPointsMap& points, float sensor_x, float sensor_y,
                                    float sensor_z) {
  Rays rays(getResolution());
  addPoints(mrpt::poses::CPose3D(), points, rays);
  insertScan(rays.ends, octomap::point3d(sensor_x, sensor_y, sensor_z));
  publish();
}

bool CProbOctoMap::internal_canComputeObservationLikelihood(const CObservation& obs) const {
  return IS_DERIVED(obs, CObservation2DRangeScan) || IS_DERIVED(obs, CObservation3DRangeScan) ||
         IS_DERIVED(obs, CObservationVelodyneScan) || IS_DERIVED(obs, CObservationPointCloud);
}

double CProbOctoMap::internal_computeObservationLikelihood(
    const CObservation& obs, const mrpt::poses::CPose3D& takenFrom) const {
  const auto rays = raysOf(obs, takenFrom, getResolution());
  if (!rays) return 0;
  const size_t step = std::max<size_t>(1, likelihoodOptions.decimation);
  double log_likelihood = 0;
  octomap::OcTreeKey key;
  for (size_t i = 0; i < rays->ends.size(); i += step)
    if (m_octree->coordToKeyChecked(rays->ends[i], key))
      if (const auto* node = m_octree->search(key))
        log_likelihood += std::log(node->getOccupancy());
  return log_likelihood;
}

void CProbOctoMap::insertPointCloud(const CPointsMap& points) {
  Rays rays(getResolution());
  addPoints(mrpt::poses::CPose3D(), points, rays);
  applySensorModel();
  for (const auto& p : rays.ends) m_octree->updateNode(p, true, true);
  const auto known = static_cast<InnerNodes>(m_tree_state.innerNodes());
  m_tree_state.setInnerNodes(static_cast<uint8_t>(
      mrpt::fusion::finishLazyUpdates(*m_octree, insertionOptions.pruning, known)));
  publish();
}

void CProbOctoMap::updateVoxel(double x, double y, double z, bool occupied) {
  applySensorModel();
  m_octree->updateNode(x, y, z, occupied);
}

bool CProbOctoMap::getPointOccupancy(float x, float y, float z, double& prob_occupancy) const {
  octomap::OcTreeKey key;
  if (!mrpt::fusion::keyAt(*m_octree, {x, y, z}, key)) return false;
  const auto* node = m_octree->search(key);
  if (!node) return false;
  prob_occupancy = node->getOccupancy();
  return true;
}

bool CProbOctoMap::castRay(const mrpt::math::TPoint3D& origin,
                           const mrpt::math::TPoint3D& direction, mrpt::math::TPoint3D& end,
                           bool ignoreUnknownCells, double maxRange) const {
  const auto toOctomap = [](const mrpt::math::TPoint3D& p) {
    return octomap::point3d(static_cast<float>(p.x), static_cast<float>(p.y),
                            static_cast<float>(p.z));
  };
  octomap::point3d hit;
  const bool found =
      m_octree->castRay(toOctomap(origin), toOctomap(direction), hit, ignoreUnknownCells, maxRange);
  end = {hit.x(), hit.y(), hit.z()};
  return found;
}
