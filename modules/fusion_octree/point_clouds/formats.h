// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "fusion_octree/point_clouds/point_cloud.h"

/** \file
 * The formats of parsePointCloud(). */

namespace mrpt::fusion {

/** True if the bytes begin like a `.pcd` file. Blanks may come first. */
bool isPcd(std::string_view beginning);
/** True if the bytes begin like a `.ply` file. */
bool isPly(std::string_view beginning);

/** Reads a `.pcd` file that is not packed. \exception std::runtime_error See parsePointCloud(). */
PointCloud parsePcd(std::string_view bytes);
/** Reads a `.ply` file that is not packed. \exception std::runtime_error See parsePointCloud(). */
PointCloud parsePly(std::string_view bytes);

}  // namespace mrpt::fusion
