// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Map files, simplemaps and rawlogs, missions among them. */

#include <mrpt/fusion/map_files.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"
#include "support/mrpt_tools.h"
#include "support/observations.h"

using namespace mrpt::fusion;
using namespace mrpt::obs;
using mrpt::poses::CPose3D;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static fuzz::MemoryFile file;
  const std::string& path = file.with(fuzz::asText(data, size));
  fuzz::accepts([&] { loadMap(path); });
  fuzz::accepts([&] { loadLocalMaps(path); });
  return 0;
}

namespace {

CObservation::Ptr at(double seconds, const CObservation::Ptr& observation) {
  observation->timestamp = mrpt::Clock::fromDouble(1.6e9 + seconds);
  return observation;
}

CObservation::Ptr robotAt(const CPose3D& pose) {
  auto observation = CObservationRobotPose::Create();
  observation->pose.mean = pose;
  return observation;
}

CObservation::Ptr odometryAt(const mrpt::poses::CPose2D& pose) {
  auto observation = CObservationOdometry::Create();
  observation->odometry = pose;
  return observation;
}

CSensoryFrame frameOf(const CObservation::Ptr& observation) {
  CSensoryFrame frame;
  frame.insert(observation);
  return frame;
}

CObservation::Ptr cloud() { return map_tests::cloudOf(map_tests::domePoints(1, 20)); }
CObservation::Ptr scan() { return map_tests::scan2d(); }

CActionCollection movement() {
  CActionRobotMovement3D movement;
  movement.poseChange.mean = CPose3D(0.1, 0, 0, 0.1, 0, 0);
  CActionCollection actions;
  actions.insert(movement);
  return actions;
}

std::string simpleMap() {
  mrpt::maps::CSimpleMap frames;
  frames.insert(mrpt::poses::CPose3DPDFGaussian(CPose3D(1, 0, 0, 0, 0, 0)), frameOf(cloud()));
  return map_tests::serialized(frames);
}

std::string mission() {
  std::string bytes;
  for (const char* robot : {"a", "b"}) {
    CObservationLocalMap map;
    map.sensorLabel = robot;
    map.map = std::make_shared<mrpt::maps::CProbOctoMap>(*fuzz::smallTrees()[3]);
    bytes += map_tests::serialized(map);
  }
  return bytes;
}

std::string missionOfDiffs() {
  std::string bytes;
  MapDiffs diffs("a");
  for (const auto& tree : fuzz::smallTrees())
    if (const auto diff = diffs.next(*tree)) bytes += map_tests::serialized(*diff);
  return bytes;
}

}  // namespace

std::vector<std::string> fuzzSeeds() {
  using map_tests::serialized;
  return {
      serialized(*at(0, robotAt({}))) + serialized(*at(0.5, cloud())) +
          serialized(*at(1, robotAt(CPose3D(1, 0, 0, 0, 0, 0)))),
      serialized(*at(0, odometryAt({}))) + serialized(*at(0.5, scan())) +
          serialized(*at(1, odometryAt({1, 0, 0.2}))),
      serialized(movement()) + serialized(frameOf(cloud())),
      simpleMap(),
      mission(),
      missionOfDiffs(),
      serialized(mrpt::maps::CProbOctoMap(*fuzz::smallTrees()[3])),
  };
}
