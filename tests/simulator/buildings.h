// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "world.h"

namespace mrpt::fusion::sim {

/** Edge of the voxels of the generated buildings [m]. */
constexpr double kBuildingVoxelSize = 0.05;

/** A hall of 40 x 15 x 3 m, cluttered and populated.
 *
 * x runs along the hall, from 0 to 40; the glass front, with a terrace before it, is at y = 0. The
 * floor is at z = 0. People walk in the aisles, where no furniture is. Always the same one.
 */
World lobby();

/** A storey of offices of 50 x 40 x 3 m, with nobody in.
 *
 * Three corridors along x, from 0 to 50, and two along y, from 0 to 40, with rooms on either side
 * that are much alike. The floor is at z = 0. Always the same one.
 */
World office();

/** A large storey of offices of 121 x 94 x 3 m, with nobody in.
 *
 * Seven corridors along x and six along y make a grid of 42 crossings. The distances between the
 * corridors differ by up to a fifth; the rooms are those of office(). The floor is at z = 0. Always
 * the same one.
 */
World storey();

}  // namespace mrpt::fusion::sim
