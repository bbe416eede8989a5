// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/random/RandomGenerators.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "voxel_grid.h"

namespace mrpt::fusion::sim {

/** A piece of furniture: boxes [m] in its own frame, z up from the floor (of lamps: the ceiling).
 *
 * Its front is where y is positive; what belongs to a wall has its back at y = 0, all else its
 * middle at the origin.
 */
using Furniture = std::vector<Eigen::AlignedBox3d>;

/** Where a piece stands in the world [m, rad]. */
struct Spot {
  Eigen::Vector3d at;
  double yaw;
};

Furniture chair();
Furniture armchair();
Furniture table(double length, double width);
Furniture bench(double length);
Furniture bin();
Furniture signStand();
Furniture hangingLamp();                        //!< Hangs from the ceiling.
Furniture hangingSign();                        //!< Hangs from the ceiling.
Furniture plant(random::CRandomGenerator&);     //!< In a tub; its leaves are drawn.
Furniture desk(double length);                  //!< With drawers and a screen; stands at a wall.
Furniture shelf(double length, double height);  //!< Stands at a wall.
Furniture cupboard(double length, double height, double depth);  //!< Closed; stands at a wall.
Furniture receptionDesk();

/** Occupies the voxels of a piece. */
void place(const Furniture& piece, const Spot& spot, VoxelGrid& grid);

/** Whether a piece touches nothing that is in the grid, and keeps `gap` [m] to all sides. */
bool fits(const Furniture& piece, const Spot& spot, double gap, const VoxelGrid& grid);

/** Box in the world that holds the piece [m]. */
Eigen::AlignedBox3d extentOf(const Furniture& piece, const Spot& spot);

}  // namespace mrpt::fusion::sim
