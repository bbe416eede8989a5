// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/voxels.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "fusion_report/image.h"

/** \file
 * The picture of two maps from above. */

namespace mrpt::fusion {

/** Both maps from above, with B at one pose. */
struct TopViewPanel {
  std::string title;        ///< Text above the panel
  Eigen::Isometry3d T_a_b;  ///< Pose of B in A's frame
};

/** Draws one panel for each pose, in one picture. Map A is orange, map B is blue, and places of
 * both are black. A column with more voxels has a stronger colour, so that walls stand out from
 * floors. A bar shows 5 m. Each map has at least one voxel. O(voxels). */
Image drawTopView(const OccupiedVoxels& a, const OccupiedVoxels& b,
                  const std::vector<TopViewPanel>& panels);

}  // namespace mrpt::fusion
