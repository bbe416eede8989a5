// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * mission_player record DRIVE.rawlog MISSION.rawlog SCANS PERIOD RESOLUTION: builds the map of a
 * drive, and records its changes (CObservationMapDiff): one change for each SCANS scans, which
 * stands for PERIOD seconds.
 *
 * mission_player play MISSION.rawlog MAP.ot SPEED: writes the map as it was at each time, SPEED
 * times as fast, as a SLAM program would. */
#include <mrpt/io/CFileOutputStream.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/serialization/CArchive.h>

#include <chrono>
#include <exception>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace {

using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationMapDiff;

mrpt::obs::CRawlog rawlogOf(const std::string& path) {
  mrpt::obs::CRawlog rawlog;
  if (!rawlog.loadFromRawLogFile(path)) throw std::runtime_error(path + ": cannot be read");
  return rawlog;
}

void record(const std::string& drive, const std::string& mission, size_t scans, double period,
            double resolution) {
  mrpt::io::CFileOutputStream file(mission);
  auto archive = mrpt::serialization::archiveFrom(file);
  mrpt::fusion::MapDiffs diffs("robot");
  CProbOctoMap map(resolution);
  mrpt::poses::CPose3D robot;
  size_t inserted = 0;
  for (const auto& object : rawlogOf(drive)) {
    if (const auto pose = std::dynamic_pointer_cast<mrpt::obs::CObservationRobotPose>(object))
      robot = pose->pose.mean;
    const auto scan = std::dynamic_pointer_cast<mrpt::obs::CObservationPointCloud>(object);
    if (!scan || !map.insertObservation(*scan, robot) || inserted++ % scans != 0) continue;
    if (const auto diff = diffs.next(std::as_const(map).octree())) {
      const auto steps = static_cast<double>(inserted / scans);
      diff->timestamp = mrpt::Clock::fromDouble(1.7e9 + steps * period);
      archive << *diff;
    }
  }
}

void play(const std::string& mission, const std::string& path, double speed) {
  CProbOctoMap map;
  const auto begin = std::chrono::steady_clock::now();
  std::optional<double> first;
  for (const auto& object : rawlogOf(mission)) {
    const auto diff = std::dynamic_pointer_cast<CObservationMapDiff>(object);
    if (!diff || !map.insertObservation(*diff))
      throw std::runtime_error(mission + ": is no record");
    const double time = mrpt::Clock::toDouble(diff->timestamp);
    if (!first) first = time;
    std::this_thread::sleep_until(begin +
                                  std::chrono::duration_cast<std::chrono::nanoseconds>(
                                      std::chrono::duration<double>((time - *first) / speed)));
    map.saveToOcTreeFile(path);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string command = argc > 1 ? argv[1] : "";
  if (command == "record" && argc == 7)
    record(argv[2], argv[3], std::stoul(argv[4]), std::stod(argv[5]), std::stod(argv[6]));
  else if (command == "play" && argc == 5)
    play(argv[2], argv[3], std::stod(argv[4]));
  else
    return 2;
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
