// SPDX-License-Identifier: BSD-3-Clause
// fuse_two_maps A.rawlog B.rawlog FUSED.ot: two robots' maps made one, inside of a SLAM program.
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>

#include <iostream>

/** What a robot's SLAM does all the time: insert each scan at the robot's pose, in a frame of its
 * own. */
mrpt::maps::CProbOctoMap mapOf(const std::string& rawlog) {
  mrpt::obs::CRawlog recording;
  if (!recording.loadFromRawLogFile(rawlog)) throw std::runtime_error(rawlog + ": not a rawlog");
  mrpt::maps::CProbOctoMap map(0.10);  // voxel size, m
  mrpt::poses::CPose3D robot;
  for (const auto& object : recording) {
    if (auto known = std::dynamic_pointer_cast<mrpt::obs::CObservationRobotPose>(object))
      robot = known->pose.mean;
    else if (auto scan = std::dynamic_pointer_cast<mrpt::obs::CObservation>(object))
      map.insertObservation(*scan, robot);
  }
  return map;
}

int main(int argc, char** argv) try {
  if (argc != 4) throw std::runtime_error("usage: fuse_two_maps A.rawlog B.rawlog FUSED.ot");
  const mrpt::maps::CProbOctoMap a = mapOf(argv[1]), b = mapOf(argv[2]);
  const std::string path = argv[3];

  // [README]
  // The robots have never met: nothing is known of b's pose in a's frame but that up is up.
  mrpt::slam::CProbabilisticMapMatching pmm;
  mrpt::slam::CProbabilisticMapMatching::TReturnInfo info;
  auto pose = pmm.Align3DPDF(&a, &b, mrpt::fusion::noGuess(), info);
  if (!info.evaluation.accepted) {
    for (const auto& reason : info.evaluation.against()) std::cerr << reason << "\n";
    return 3;
  }

  // Later the last pose is a guess, good to 1 m and 0.1 rad: one standard deviation each.
  mrpt::poses::CPose3DPDFGaussian guess(pose->getMeanVal());
  guess.cov.setDiagonal(std::vector<double>{1, 1, 1, 0.01, 0.01, 0.01});
  pose = pmm.Align3DPDF(&a, &b, guess, info);
  if (info.evaluation.accepted)
    pmm.merge(a, b, pose->getMeanVal()).saveToOcTreeFile(path);  // in a's frame
  // [README]

  std::cout << pose->getMeanVal() << " with probability " << info.evaluation.probability << "\n";
  return info.evaluation.accepted ? 0 : 3;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
