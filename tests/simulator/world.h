// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "voxel_grid.h"

namespace mrpt::fusion::sim {

/** A person at one instant: an upright capsule that stands on the floor. */
struct Capsule {
  Eigen::Vector3d foot;  //!< Lowest point, in the world [m].
  double height;         //!< [m], at least twice the radius.
  double radius;         //!< [m]
};

/** Distance [m] at which a ray enters the capsule.
 * \param[in] origin In the world [m].
 * \param[in] direction Unit vector.
 * \return Nothing if it does not; 0 if the origin itself is inside.
 */
std::optional<double> castRay(const Capsule& capsule, const Eigen::Vector3d& origin,
                              const Eigen::Vector3d& direction);

/** Someone who walks to and fro along a path, at all times. */
struct Person {
  std::vector<Eigen::Vector2d> way;  //!< Corners of the path, at least two, in the world [m].
  double speed = 1.0;                //!< [m/s]
  double headStart = 0.0;            //!< Way already made at time 0 [m].
  double floorZ = 0.0;               //!< Height of the floor in the world [m].
  double height = 1.7;               //!< [m]
  double radius = 0.25;              //!< [m]

  Capsule at(double time) const;  //!< Where the person is at `time` [s].
};

/** All that beams of a lidar can hit. */
struct World {
  /** A world of nothing but voxels; implicit, as that is what a building's OctoMap is. */
  World(VoxelGrid voxels) : solid(std::move(voxels)) {}

  VoxelGrid solid;
  std::optional<VoxelGrid> glass;  //!< Returns few beams and lets all others through.
  double glassReturn = 0.0;        //!< Share of beams that glass returns [0..1].
  std::vector<Person> people;
};

std::vector<Capsule> peopleAt(const World& world, double time);  //!< At `time` [s].

/** Distance [m] at which a beam meets what returns it.
 * \param[in] people The world's, at the instant of the beam.
 * \param[in] origin In the world [m].
 * \param[in] direction Unit vector.
 * \param[in] maxRange Where the beam ends [m].
 * \param[in] glassReturns Whether glass, if met first, returns this beam or lets it through.
 * \return Nothing if the beam ends before; 0 if the origin itself is inside of something.
 */
std::optional<double> castRay(const World& world, const std::vector<Capsule>& people,
                              const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                              double maxRange, bool glassReturns);

}  // namespace mrpt::fusion::sim
