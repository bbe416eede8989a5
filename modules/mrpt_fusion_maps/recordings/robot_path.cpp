// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads the path of the robot, and places observations by time or by the order of the log. */

#include "mrpt_fusion_maps/recordings/robot_path.h"

#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

using namespace mrpt::obs;
using mrpt::poses::CPose3D;

namespace mrpt::fusion {
namespace {

bool hasTime(const CObservation& obs) { return obs.timestamp != INVALID_TIMESTAMP; }

}  // namespace

bool isRobotPose(const CObservation& obs) {
  return dynamic_cast<const CObservationRobotPose*>(&obs) ||
         dynamic_cast<const CObservationOdometry*>(&obs);
}

void RobotPath::Poses::add(const CObservation& obs, const CPose3D& pose) {
  count++;
  if (!hasTime(obs)) return;
  with_time++;
  by_time.insert(obs.timestamp, pose);
}

void RobotPath::add(const mrpt::serialization::CSerializable& object) {
  if (const auto* pose = dynamic_cast<const CObservationRobotPose*>(&object))
    robot_poses_.add(*pose, pose->pose.mean);
  else if (const auto* odo = dynamic_cast<const CObservationOdometry*>(&object))
    odometry_.add(*odo, CPose3D(odo->odometry));
}

void RobotPath::finish() {
  for (auto* p : {&robot_poses_, &odometry_})
    p->by_time.setInterpolationMethod(mrpt::poses::imLinearSlerp);
  const size_t times = poses().by_time.size();
  has_no_times_ = times == 0 || (times == 1 && poses().count > 1);
}

const char* RobotPath::kind() const {
  return usesOdometry() ? "CObservationOdometry" : "CObservationRobotPose";
}

void RobotPath::pass(const CObservation& pose) {
  if (!has_no_times_ && !hasTime(pose)) return;
  if (const auto* known = dynamic_cast<const CObservationRobotPose*>(&pose))
    last_ = known->pose.mean;
  else if (const auto* odo = dynamic_cast<const CObservationOdometry*>(&pose);
           odo && usesOdometry())
    last_ = CPose3D(odo->odometry);
}

std::optional<CPose3D> RobotPath::poseFor(const CObservation& obs) const {
  if (has_no_times_ || !hasTime(obs)) return last_;
  CPose3D pose;
  bool valid = false;
  poses().by_time.interpolate(obs.timestamp, pose, valid);
  return valid ? std::optional(pose) : std::nullopt;
}

}  // namespace mrpt::fusion
