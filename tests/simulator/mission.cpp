// SPDX-License-Identifier: BSD-3-Clause
#include "mission.h"

#include <mrpt/config/CConfigFile.h>
#include <mrpt/core/bits_math.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace mrpt::fusion::sim {
namespace {

using mrpt::DEG2RAD;
using mrpt::poses::CPose3D;

/** One section of the mission file, read strictly. */
class Section {
 public:
  Section(const mrpt::config::CConfigFile& file, const std::string& name)
      : file_(file), name_(name) {}

  /** A value within [low, high]. */
  double number(const std::string& key, double low,
                double high = std::numeric_limits<double>::infinity()) const {
    const double value = numbers(key, text(key), 1).front();
    if (value < low || value > high) fail(key, "is out of range");
    return value;
  }

  int count(const std::string& key) const {
    const double value = number(key, 1, 1e6);
    if (value != static_cast<int>(value)) fail(key, "is not a whole number");
    return static_cast<int>(value);
  }

  /** "x y z yaw pitch roll" [m, deg]. */
  CPose3D pose(const std::string& key) const {
    const auto v = numbers(key, text(key), 6);
    return CPose3D(v[0], v[1], v[2], DEG2RAD(v[3]), DEG2RAD(v[4]), DEG2RAD(v[5]));
  }

  /** "x y; x y; ..." [m]. */
  std::vector<Eigen::Vector2d> points(const std::string& key) const {
    std::vector<Eigen::Vector2d> result;
    std::istringstream list(text(key));
    for (std::string item; std::getline(list, item, ';');) {
      const auto v = numbers(key, item, 2);
      result.emplace_back(v[0], v[1]);
    }
    return result;
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& reason) const {
    throw std::runtime_error(file_.getAssociatedFile() + ": [" + name_ + "] " + key + " " + reason);
  }

  std::string text(const std::string& key) const {
    if (!file_.keyExists(name_, key)) fail(key, "is missing");
    return file_.read_string(name_, key, "");
  }

  std::vector<double> numbers(const std::string& key, const std::string& text,
                              size_t howMany) const {
    std::istringstream words(text);
    std::vector<double> result;
    for (double value; words >> value;) result.push_back(value);
    if (!words.eof() || result.size() != howMany)
      fail(key, "should be " + std::to_string(howMany) + " number(s), not '" + text + "'");
    return result;
  }

  const mrpt::config::CConfigFile& file_;
  std::string name_;
};

Lidar readLidar(const Section& section) {
  Lidar lidar;
  lidar.rings = section.count("rings");
  lidar.columns = section.count("columns");
  lidar.elevationMin = DEG2RAD(section.number("elevation_min_deg", -90, 90));
  lidar.elevationMax = DEG2RAD(section.number("elevation_max_deg", -90, 90));
  lidar.maxRange = section.number("max_range", 0);
  lidar.rangeSigma = section.number("range_sigma", 0);
  return lidar;
}

PoseNoise readNoise(const Section& section) {
  PoseNoise noise;
  noise.driftTranslation = section.number("drift_translation", 0);
  noise.driftRotation = DEG2RAD(section.number("drift_rotation_deg", 0));
  noise.jitterTranslation = section.number("jitter_translation", 0);
  noise.jitterRotation = DEG2RAD(section.number("jitter_rotation_deg", 0));
  noise.outOfPlane = section.number("out_of_plane", 0, 1);
  return noise;
}

RobotPlan readPlan(const Section& section, const std::string& name) {
  RobotPlan plan;
  plan.name = name;
  plan.waypoints = section.points("waypoints");
  plan.floorZ = section.number("floor_z", -std::numeric_limits<double>::infinity());
  plan.scanSpacing = section.number("scan_spacing", 0.01);
  plan.speed = section.number("speed", 0.01);
  plan.startTime = section.number("start_time", 0);
  plan.radius = section.number("radius", 0);
  plan.groundClearance = section.number("ground_clearance", 0);
  plan.sensorPose = section.pose("sensor_pose");
  plan.T_w_map = section.pose("map_frame");
  return plan;
}

}  // namespace

Mission loadMission(const std::string& path) {
  if (!std::filesystem::is_regular_file(path)) throw std::runtime_error(path + ": no such file");
  mrpt::config::CConfigFile file;
  try {
    file.setFileName(path);
  } catch (const std::exception&) {  // what MRPT says is many lines long
    throw std::runtime_error(path + ": is not a configuration file");
  }

  Mission mission;
  mission.lidar = readLidar(Section(file, "lidar"));
  mission.noise = readNoise(Section(file, "noise"));
  mission.seed = static_cast<uint32_t>(
      Section(file, "noise").number("seed", 0, std::numeric_limits<uint32_t>::max()));

  std::vector<std::string> names;
  file.getAllSections(names);
  std::sort(names.begin(), names.end());
  for (const auto& name : names)
    if (name.rfind("robot_", 0) == 0) mission.robots.push_back(readPlan(Section(file, name), name));
  if (mission.robots.empty()) throw std::runtime_error(path + ": no section [robot_...]");
  return mission;
}

std::vector<Recording> runMission(const World& world, const Mission& mission) {
  std::vector<Recording> recordings;
  for (const RobotPlan& plan : mission.robots)
    recordings.push_back(simulateRobot(world, mission.lidar, mission.noise, plan,
                                       mission.seed + static_cast<uint32_t>(recordings.size())));
  return recordings;
}

}  // namespace mrpt::fusion::sim
