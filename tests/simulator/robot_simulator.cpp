// SPDX-License-Identifier: BSD-3-Clause
#include "robot_simulator.h"

#include <mrpt/core/Clock.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/random/RandomGenerators.h>
#include <mrpt/serialization/CArchive.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <unordered_map>

namespace mrpt::fusion::sim {
namespace {

using mrpt::poses::CPose3D;
using mrpt::poses::CPose3DPDFGaussian;
using mrpt::random::CRandomGenerator;

Eigen::Isometry3d toEigen(const CPose3D& pose) {
  Eigen::Isometry3d T;
  T.matrix() = pose.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>().asEigen();
  return T;
}

/** Even steps from `low` to `high`, both included, at most `step` apart. */
std::vector<double> spaced(double low, double high, double step) {
  const int steps = std::max(1, static_cast<int>(std::ceil((high - low) / step)));
  std::vector<double> values;
  for (int i = 0; i <= steps; ++i) values.push_back(low + (high - low) * i / steps);
  return values;
}

/** A straight part of a path. */
struct Leg {
  Leg(const RobotPlan& plan, size_t i)
      : from(plan.waypoints[i]),
        way(plan.waypoints[i + 1] - from),
        length(way.norm()),
        yaw(std::atan2(way.y(), way.x())) {}

  Eigen::Vector2d at(double share) const { return from + way * share; }

  Eigen::Vector2d from, way;  // [m]
  double length, yaw;         // [m], [rad]
};

/** True poses of the robot in the world, one for each scan. */
std::vector<CPose3D> posesAlong(const RobotPlan& plan) {
  std::vector<CPose3D> poses;
  for (size_t i = 0; i + 1 < plan.waypoints.size(); ++i) {
    const Leg leg(plan, i);
    if (i > 0) poses.pop_back();  // at a corner only the scan that looks ahead
    for (const double share : spaced(0, 1, plan.scanSpacing / leg.length)) {
      const Eigen::Vector2d p = leg.at(share);
      poses.emplace_back(p.x(), p.y(), plan.floorZ, leg.yaw, 0.0, 0.0);
    }
  }
  return poses;
}

/** A zero-mean pose error with independent axes; lengths [m], angles [rad]. */
CPose3DPDFGaussian poseError(double translation, double rotation, double outOfPlane) {
  CPose3DPDFGaussian error;
  error.cov.setDiagonal(
      std::vector<double>{std::pow(translation, 2), std::pow(translation, 2),
                          std::pow(translation * outOfPlane, 2), std::pow(rotation, 2),
                          std::pow(rotation * outOfPlane, 2), std::pow(rotation * outOfPlane, 2)});
  return error;
}

/** The same error once drawn: the sample becomes the mean, the covariance stays. */
CPose3DPDFGaussian drawn(CPose3DPDFGaussian error, CRandomGenerator& random) {
  double e[6];
  for (int i = 0; i < 6; ++i) e[i] = random.drawGaussian1D(0, std::sqrt(error.cov(i, i)));
  error.mean.setFromValues(e[0], e[1], e[2], e[3], e[4], e[5]);
  return error;
}

/** What the SLAM front end of the robot says, in its map frame. */
std::vector<CPose3DPDFGaussian> estimate(const std::vector<CPose3D>& truth, const CPose3D& T_w_map,
                                         const PoseNoise& noise, CRandomGenerator& random) {
  const auto jitter = poseError(noise.jitterTranslation, noise.jitterRotation, noise.outOfPlane);
  std::vector<CPose3DPDFGaussian> estimates;
  CPose3DPDFGaussian drifted(truth.front() - T_w_map);
  for (size_t i = 0; i < truth.size(); ++i) {
    if (i > 0) {
      const double way = truth[i].distanceTo(truth[i - 1]);
      const auto drift = poseError(noise.driftTranslation * std::sqrt(way),
                                   noise.driftRotation * std::sqrt(way), noise.outOfPlane);
      drifted += truth[i] - truth[i - 1];
      drifted += drawn(drift, random);
    }
    estimates.push_back(drifted + drawn(jitter, random));
  }
  return estimates;
}

/** Unit vectors in the sensor frame, ring by ring. */
std::vector<Eigen::Vector3d> beamDirections(const Lidar& lidar) {
  std::vector<Eigen::Vector3d> beams;
  for (int ring = 0; ring < lidar.rings; ++ring) {
    const double share = lidar.rings > 1 ? ring / (lidar.rings - 1.0) : 0.0;
    const double e = lidar.elevationMin + share * (lidar.elevationMax - lidar.elevationMin);
    for (int column = 0; column < lidar.columns; ++column) {
      const double azimuth = 2 * M_PI * column / lidar.columns;
      beams.emplace_back(std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth),
                         std::sin(e));
    }
  }
  return beams;
}

/** Points of the robot's body, relative to the robot on the floor [m]. */
std::vector<Eigen::Vector3d> sampleBody(const RobotPlan& plan, double step) {
  std::vector<Eigen::Vector3d> body;
  for (const double x : spaced(-plan.radius, plan.radius, step))
    for (const double y : spaced(-plan.radius, plan.radius, step))
      for (const double z : spaced(plan.groundClearance, plan.sensorPose.z(), step))
        if (std::hypot(x, y) <= plan.radius) body.emplace_back(x, y, z);
  return body;
}

/** Where the body [m] of a robot at `p` [m] hits something, if it does. */
std::optional<Eigen::Vector3d> collision(const World& world, const std::vector<Capsule>& people,
                                         const RobotPlan& plan,
                                         const std::vector<Eigen::Vector3d>& body,
                                         const Eigen::Vector2d& p) {
  const Eigen::Vector3d robot(p.x(), p.y(), plan.floorZ);
  for (const Capsule& person : people)
    if ((person.foot - robot).head<2>().norm() < person.radius + plan.radius) return person.foot;
  for (const Eigen::Vector3d& part : body) {
    const Eigen::Vector3d at = robot + part;
    if (world.solid.isOccupied(at) || (world.glass && world.glass->isOccupied(at))) return at;
  }
  return std::nullopt;
}

/** Whether glass returns the next beam. A world without glass draws no luck for it. */
bool drawGlassReturn(const World& world, CRandomGenerator& random) {
  return world.glass && random.drawUniform(0.0, 1.0) < world.glassReturn;
}

/** Rigid transform that brings `scene` to `model` [m] in the least-squares sense (Umeyama). */
CPose3D align(const std::vector<Eigen::Vector3d>& model,
              const std::vector<Eigen::Vector3d>& scene) {
  using Points = Eigen::Map<const Eigen::Matrix3Xd>;
  const Eigen::Matrix4d T_model_scene =
      Eigen::umeyama(Points(scene.front().data(), 3, scene.size()),
                     Points(model.front().data(), 3, model.size()), false);
  return CPose3D(mrpt::math::CMatrixDouble44(T_model_scene));
}

Eigen::Vector3d centreOf(const octomap::OcTreeKey& key, const octomap::OcTree& cells) {
  const octomap::point3d centre = cells.keyToCoord(key);
  return {centre.x(), centre.y(), centre.z()};
}

/** Sum of the placements of one cell's centre in a robot's map [m], and their number. */
struct Placement {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;

  Eigen::Vector3d mean() const { return sum / count; }
};
using Placements = std::unordered_map<octomap::OcTreeKey, Placement, octomap::OcTreeKey::KeyHash>;

/** Where a robot's map puts each cell of the world that it saw. */
Placements placeCells(const Recording& recording, const octomap::OcTree& cells) {
  Placements placements;
  for (const Scan& scan : recording.scans) {
    const Eigen::Isometry3d T_map_w =
        toEigen(scan.estimatedPose.mean) * toEigen(scan.truePose).inverse();
    for (const auto& hit : scan.hits) {
      const octomap::OcTreeKey key = cells.coordToKey(hit.x, hit.y, hit.z);
      Placement& placement = placements[key];
      placement.sum += T_map_w * centreOf(key, cells);
      ++placement.count;
    }
  }
  return placements;
}

/** A rawlog that recordings are written to, one after the other. */
class RawlogWriter {
 public:
  explicit RawlogWriter(const std::string& path) {
    if (!file_.open(path)) throw std::runtime_error(path + ": cannot be written");
  }

  void write(const Recording& recording) {
    auto archive = mrpt::serialization::archiveFrom(file_);
    for (const Scan& scan : recording.scans) {
      archive << poseOf(scan) << cloudOf(scan, recording.sensorPose);
      time_ += std::chrono::milliseconds(100);
    }
  }

 private:
  mrpt::obs::CObservationRobotPose poseOf(const Scan& scan) const {
    mrpt::obs::CObservationRobotPose pose;
    pose.sensorLabel = "slam_pose";
    pose.timestamp = time_;
    pose.pose = scan.estimatedPose;
    return pose;
  }

  mrpt::obs::CObservationPointCloud cloudOf(const Scan& scan, const CPose3D& sensorPose) const {
    mrpt::obs::CObservationPointCloud cloud;
    cloud.sensorLabel = "lidar";
    cloud.timestamp = time_;
    cloud.sensorPose = sensorPose;
    auto points = mrpt::maps::CSimplePointsMap::Create();
    points->reserve(scan.points.size());
    for (const auto& p : scan.points) points->insertPointFast(p.x, p.y, p.z);
    cloud.pointcloud = points;
    return cloud;
  }

  mrpt::io::CFileGZOutputStream file_;
  mrpt::Clock::time_point time_ = mrpt::Clock::fromDouble(1.7e9);
};

}  // namespace

void checkPathIsFree(const World& world, const RobotPlan& plan) {
  if (plan.waypoints.size() < 2) throw std::runtime_error(plan.name + ": less than two waypoints");

  // So that no voxel slips through between two samples.
  const double step = world.solid.voxelSize() / 2;
  const std::vector<Eigen::Vector3d> body = sampleBody(plan, step);
  double time = plan.startTime;
  for (size_t i = 0; i + 1 < plan.waypoints.size(); ++i) {
    const Leg leg(plan, i);
    for (const double share : spaced(0, 1, step / leg.length)) {
      const auto people = peopleAt(world, time + share * leg.length / plan.speed);
      const auto at = collision(world, people, plan, body, leg.at(share));
      if (!at) continue;
      std::ostringstream message;
      message << plan.name << ": the way from waypoint " << i + 1 << " to " << i + 2
              << " is blocked at (" << at->x() << ", " << at->y() << ", " << at->z() << ") m";
      throw std::runtime_error(message.str());
    }
    time += leg.length / plan.speed;
  }
}

Recording simulateRobot(const World& world, const Lidar& lidar, const PoseNoise& noise,
                        const RobotPlan& plan, uint32_t seed) {
  checkPathIsFree(world, plan);

  CRandomGenerator random(seed);
  const std::vector<CPose3D> truth = posesAlong(plan);
  const std::vector<CPose3DPDFGaussian> estimates = estimate(truth, plan.T_w_map, noise, random);
  const std::vector<Eigen::Vector3d> beams = beamDirections(lidar);

  Recording recording{plan.sensorPose, {}};
  double time = plan.startTime;
  for (size_t i = 0; i < truth.size(); ++i) {
    if (i > 0) time += truth[i].distanceTo(truth[i - 1]) / plan.speed;
    const std::vector<Capsule> people = peopleAt(world, time);
    Scan scan{truth[i], estimates[i], {}, {}};
    const Eigen::Isometry3d T_w_sensor = toEigen(truth[i] + plan.sensorPose);
    const Eigen::Vector3d origin = T_w_sensor.translation();
    for (const Eigen::Vector3d& beam : beams) {
      const Eigen::Vector3d direction = T_w_sensor.linear() * beam;
      const auto range =
          castRay(world, people, origin, direction, lidar.maxRange, drawGlassReturn(world, random));
      if (!range) continue;
      const Eigen::Vector3d hit = origin + *range * direction;
      const Eigen::Vector3d point = random.drawGaussian1D(*range, lidar.rangeSigma) * beam;
      scan.hits.emplace_back(hit.x(), hit.y(), hit.z());
      scan.points.emplace_back(point.x(), point.y(), point.z());
    }
    recording.scans.push_back(std::move(scan));
  }
  return recording;
}

CPose3D relativePoseTruth(const Recording& a, const Recording& b, double cellSize) {
  const octomap::OcTree cells(cellSize);  // only its arithmetic of keys
  const Placements inA = placeCells(a, cells), inB = placeCells(b, cells);

  std::vector<Eigen::Vector3d> model, scene;
  for (const auto& [key, placement] : inA)
    if (const auto twin = inB.find(key); twin != inB.end()) {
      model.push_back(placement.mean());
      scene.push_back(twin->second.mean());
    }
  if (model.size() < 3) throw std::runtime_error("the robots have seen no common part");
  return align(model, scene);
}

CPose3D worldPoseTruth(const Recording& recording, double cellSize) {
  const octomap::OcTree cells(cellSize);  // only its arithmetic of keys
  std::vector<Eigen::Vector3d> model, scene;
  for (const auto& [key, placement] : placeCells(recording, cells)) {
    model.push_back(placement.mean());
    scene.push_back(centreOf(key, cells));
  }
  if (model.size() < 3) throw std::runtime_error("the robot has seen nothing");
  return align(model, scene);
}

std::vector<Recording> withoutPoseErrors(std::vector<Recording> recordings, double cellSize) {
  const CPose3D T_a_w = worldPoseTruth(recordings.front(), cellSize);
  for (Recording& recording : recordings)
    for (Scan& scan : recording.scans)
      scan.estimatedPose = CPose3DPDFGaussian(T_a_w + scan.truePose);
  return recordings;
}

void writeRawlog(const Recording& recording, const std::string& path) {
  RawlogWriter(path).write(recording);
}

void writeRawlog(const std::vector<Recording>& recordings, const std::string& path) {
  RawlogWriter writer(path);
  for (const Recording& recording : recordings) writer.write(recording);
}

}  // namespace mrpt::fusion::sim
