// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DInterpolator.h>

#include <cstddef>
#include <optional>

/** \file
 * The path of the robot in a rawlog of observations. */

namespace mrpt::fusion {

/** Returns whether an observation is a pose of the robot, which places other observations. */
bool isRobotPose(const mrpt::obs::CObservation& obs);

/** The path of the robot in a rawlog of observations. The poses are CObservationRobotPose or, if
 * there are none, CObservationOdometry.
 *
 * The pose of an observation is interpolated to its time. If there are no times, the order of the
 * log counts: the pose is the last pose before the observation. There are no times if the
 * observation has no time stamp, if no pose has a time stamp, or if all poses have the same time
 * stamp. */
class RobotPath {
 public:
  /** Adds an object of the rawlog if it is a pose. */
  void add(const mrpt::serialization::CSerializable& object);
  /** Ends the path: all poses are added. */
  void finish();

  bool empty() const { return poses().count == 0; }  ///< True if there is no pose
  /** True if the order of the log places all observations. */
  bool hasNoTimes() const { return has_no_times_; }
  /** Number of poses that are not used because only other poses have a time stamp. */
  size_t posesWithoutTime() const { return has_no_times_ ? 0 : poses().count - poses().with_time; }
  const char* kind() const;  ///< Class of the poses

  /** Takes a pose that comes next in the log. */
  void pass(const mrpt::obs::CObservation& pose);

  /** Returns the pose of the robot for an observation that comes next in the log. Nothing: it is
   * before the first pose or after the last pose. */
  std::optional<mrpt::poses::CPose3D> poseFor(const mrpt::obs::CObservation& obs) const;

 private:
  /** The poses of one class. */
  struct Poses {
    mrpt::poses::CPose3DInterpolator by_time;
    size_t count = 0, with_time = 0;

    void add(const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& pose);
  };
  bool usesOdometry() const { return robot_poses_.count == 0; }
  const Poses& poses() const { return usesOdometry() ? odometry_ : robot_poses_; }

  Poses robot_poses_, odometry_;
  bool has_no_times_ = false;
  std::optional<mrpt::poses::CPose3D> last_;  // last pose that was passed
};

}  // namespace mrpt::fusion
