// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Robots with a 3-D lidar that drive through a known building, each mapping in a frame of its own.
 *
 * Everything is a pure function of its arguments: the same seed gives the same bytes.
 *
 * Frames: `world` is the frame of the building; `map` is the frame in which one robot builds its
 * map; `robot` lies on the floor below the robot, x forward and z up; `sensor` is the lidar.
 */
#pragma once

#include <mrpt/math/TPoint3D.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <cstdint>
#include <string>
#include <vector>

#include "world.h"

namespace mrpt::fusion::sim {

/** A spinning lidar: `rings` x `columns` beams, the columns spread over a full turn. */
struct Lidar {
  int rings = 32;                 //!< Beams from bottom to top.
  int columns = 720;              //!< Beams per turn.
  double elevationMin = -0.5236;  //!< Elevation of the lowest ring [rad].
  double elevationMax = 0.5236;   //!< Elevation of the highest ring [rad].
  double maxRange = 15.0;         //!< Beams that reach no surface within this give no point [m].
  double rangeSigma = 0.02;       //!< Gaussian noise of each range, one sigma [m].
};

/** What a SLAM front end leaves wrong: a drift that grows with the way, and a jitter of each scan.
 *
 * All are one sigma of a Gaussian, per axis: x, y, yaw in full; z, roll and pitch, which the floor
 * and gravity hold, times `outOfPlane`.
 */
struct PoseNoise {
  double driftTranslation = 0.003;  //!< Random walk [m per sqrt(m) travelled].
  double driftRotation = 0.00035;   //!< Random walk [rad per sqrt(m) travelled].
  double jitterTranslation = 0.01;  //!< Of each scan, independent of all others [m].
  double jitterRotation = 0.00175;  //!< Of each scan, independent of all others [rad].
  double outOfPlane = 0.3;          //!< Share of the above in z, roll and pitch [0..1].
};

/** Where a robot drives, what it carries, and where its map frame lies. */
struct RobotPlan {
  std::string name;                        //!< For files and messages.
  std::vector<Eigen::Vector2d> waypoints;  //!< Corners of its path, in the world [m].
  double floorZ = 0.0;                     //!< Height of the floor in the world [m].
  double scanSpacing = 0.5;                //!< Way between two scans, at most [m].
  double speed = 0.5;                      //!< On all of its way [m/s]; a scan is an instant.
  double startTime = 0.0;                  //!< When it sets off; people walk by this clock [s].
  double radius = 0.2;                     //!< The body is a cylinder of this radius [m]...
  double groundClearance = 0.2;            //!< ...from this above the floor up to the sensor [m].
  mrpt::poses::CPose3D sensorPose;         //!< Lidar in the robot's frame.
  mrpt::poses::CPose3D T_w_map;  //!< The robot's map frame in the world: p_w = T_w_map p_map.
};

/** One turn of the lidar. `points[i]` and `hits[i]` come from the same beam. */
struct Scan {
  mrpt::poses::CPose3D truePose;                  //!< Robot in the world.
  mrpt::poses::CPose3DPDFGaussian estimatedPose;  //!< Robot in its own map frame, with drift.
  std::vector<mrpt::math::TPoint3Df> points;      //!< As measured, in the sensor frame [m].
  std::vector<mrpt::math::TPoint3Df> hits;        //!< Where they truly lie, in the world [m].
};

/** All that one robot saw. */
struct Recording {
  mrpt::poses::CPose3D sensorPose;  //!< Lidar in the robot's frame.
  std::vector<Scan> scans;
};

/** Makes sure that the robot can drive its path.
 * \exception std::runtime_error Names the first straight leg on which the body of the robot hits
 * an occupied voxel, glass or a person, and where; or says that there are no two waypoints.
 */
void checkPathIsFree(const World& world, const RobotPlan& plan);

/** Drives one robot along its path and scans on the way.
 *
 * The robot looks along the leg it drives. The estimated poses start at the true one and gather
 * errors as told by `noise`; their covariances are those of that very error model, propagated to
 * first order. Cost: about a microsecond per beam indoors.
 * \exception std::runtime_error See checkPathIsFree().
 */
Recording simulateRobot(const World& world, const Lidar& lidar, const PoseNoise& noise,
                        const RobotPlan& plan, uint32_t seed);

/** Pose of b's map frame in a's: p_a = T_a_b p_b, as far as two drifted maps can have one.
 *
 * Neither map is a rigid copy of the world, so the relation of the two frames at the start of the
 * drives is not the transform under which the maps coincide best. That one is computed here, from
 * the simulator's own errors and from no map: a robot places a world point p at
 * `estimatedPose * truePose^-1 * p` in its map, a placement that differs from scan to scan. For
 * each cell of the world hit by both robots, take the mean placement of the cell's centre over all
 * the hits in it, per robot; then solve for the rigid transform that aligns b's placements with
 * a's in the least-squares sense (Umeyama without scale, each cell with the same weight).
 * Without pose noise this is exactly the relation of the two frames.
 *
 * \param[in] cellSize Edge of the cells of the world [m].
 * \exception std::runtime_error If the robots have fewer than three cells in common.
 */
mrpt::poses::CPose3D relativePoseTruth(const Recording& a, const Recording& b,
                                       double cellSize = 0.1);

/** Pose of the world in a robot's map frame: p_map = T_map_w p_w, as far as a drifted map has one.
 *
 * As relativePoseTruth(), with the cells' own centres in place of where robot b places them: this
 * is where an undistorted map of the world fits the robot's map best.
 * \exception std::runtime_error If the robot has seen fewer than three cells.
 */
mrpt::poses::CPose3D worldPoseTruth(const Recording& recording, double cellSize = 0.1);

/** The same scans as if no robot had ever erred about its pose, all in the map frame of the first.
 *
 * The points stay as measured. The estimated poses become the true ones, moved by the first
 * robot's worldPoseTruth() and without covariance. A map built of all these scans is the best that
 * merging the robots' maps in the frame of the first could come to.
 * \exception std::runtime_error If the first robot has seen fewer than three cells.
 */
std::vector<Recording> withoutPoseErrors(std::vector<Recording> recordings, double cellSize = 0.1);

/** Writes an observations-only MRPT rawlog: per scan a CObservationRobotPose "slam_pose" (the
 * estimated pose) and a CObservationPointCloud "lidar" of the same time stamp. Scans are 0.1 s
 * apart, from a fixed date on; recordings follow each other.
 * \exception std::runtime_error If the file cannot be written.
 */
void writeRawlog(const Recording& recording, const std::string& path);
void writeRawlog(const std::vector<Recording>& recordings, const std::string& path);

}  // namespace mrpt::fusion::sim
