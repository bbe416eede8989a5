// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

/** \file Two maps whose relative pose is known, poses to start from, and how wrong a result is. */

namespace mrpt::fusion::benchmark {

struct MapPair {
  std::string folder, name;  ///< where it is, and the last part of that
  std::shared_ptr<const octomap::OcTree> a, b;
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< the truth
  Eigen::Vector3d centre_of_b = Eigen::Vector3d::Zero();  ///< of its occupied voxels, B's frame, m
};

/** A map file's octree. \exception std::runtime_error As mrpt::fusion::loadMap(). */
std::shared_ptr<const octomap::OcTree> loadTree(const std::string& path);
/** A 4x4 row-major matrix. \exception std::runtime_error If it is not one. */
Eigen::Isometry3d loadPose(const std::string& path);

/** Reads T_a_b.txt and the maps map_a and map_b: .bt if that file exists, else .ot.
 * \exception std::runtime_error What is missing or wrong, and where. */
MapPair loadMapPair(const std::string& folder);

/** A pose to start from: the truth, turned by dyaw about the vertical through B's middle and moved
 * by (dx, dy), all in A's frame. */
struct Start {
  unsigned index;
  double dx, dy;  ///< m
  double dyaw;    ///< rad
};
Eigen::Isometry3d poseOf(const Start& start, const MapPair& pair);

/** The paper's 125 starts (Sec. VI-C): x, y in {-2..2} m, yaw in {-15, -7.5, .. 15} deg. */
std::vector<Start> paperStarts();
/** Starts drawn evenly within +-translation (m) and +-yaw (rad); the same on every run. */
std::vector<Start> randomStarts(unsigned count, double translation, double yaw, unsigned seed);

/** 0.5 m and 5 deg off the truth: as near as a usual guess. */
Start nearStart();

struct PoseError {
  double paper = 0;   ///< |translation of T_e T_g^-1|, Sec. VI-A.2, m
  double centre = 0;  ///< how far B's middle is from where it should be, m
  double angle = 0;   ///< rad
};
PoseError errorOf(const Eigen::Isometry3d& T_a_b, const MapPair& pair);

/** The normalised estimation error squared: the error by a covariance of a left perturbation
 * (translation, rotation); its mean is 6 where the covariance means what it says. */
double neesOf(const Eigen::Isometry3d& T_a_b, const Eigen::Matrix<double, 6, 6>& covariance,
              const Eigen::Isometry3d& truth);

/** A map with each leaf's log-odds as \a change has it; what becomes NaN is unknown. */
std::shared_ptr<const octomap::OcTree> changed(
    const octomap::OcTree& map,
    const std::function<float(const octomap::OcTreeKey& key, float log_odds)>& change);

/** A map at another resolution, m. */
std::shared_ptr<const octomap::OcTree> resampled(const octomap::OcTree& map, double resolution);

/** A map with a third of its obstacles, spread at random, and all of its free space. */
std::shared_ptr<const octomap::OcTree> withAThirdOfObstacles(const octomap::OcTree& map);

/** The part of a map, known space and all, on the side of a plane where `direction . p > offset`
 * (m; a leaf of several voxels is divided). */
std::shared_ptr<const octomap::OcTree> cropMap(const octomap::OcTree& map,
                                               const Eigen::Vector3d& direction, double offset);

/** The mirror image of a map (x is -x), known space and all. */
std::shared_ptr<const octomap::OcTree> mirrored(const octomap::OcTree& map);

/** Mean share of the maps' occupied voxels that have an occupied voxel of the other within one
 * voxel (at least 0.1 m) at the true pose. */
double trueOverlap(const MapPair& pair);

/** Parts of both maps, on either side of two parallel vertical planes: A's part ends at one, B's
 * begins at the other. Each part has at least 55 % of the voxels of its map. */
MapPair randomParts(const MapPair& pair, std::mt19937& generator);

}  // namespace mrpt::fusion::benchmark
