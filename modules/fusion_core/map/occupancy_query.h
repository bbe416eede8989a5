// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>

#include "fusion_core/map/map_voxels.h"

/** \file
 * What a map says of a point. */

namespace mrpt::fusion {

/** What a map says of an obstacle at a point. */
enum class Finding : uint8_t {
  Unknown,   ///< The map does not know the place
  Agrees,    ///< The map has an obstacle there or in a neighbouring voxel
  Conflicts  ///< The map has seen the place free, and has no obstacle around it
};

/** What a map says of an obstacle at a point (m, the map's frame). Only a place seen free with
 * nothing occupied around it contradicts: half a voxel of quantisation in each map is no
 * contradiction. */
Finding findingAt(const MapVoxels& map, const Eigen::Vector3d& p);

/** Whether a map has seen free space at a point, m, the map's frame. */
bool isFree(const MapVoxels& map, const Eigen::Vector3d& p);

}  // namespace mrpt::fusion
