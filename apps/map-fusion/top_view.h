// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/voxels.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

/** Two maps seen from above, B moved by a pose. */
struct TopViewPanel {
  std::string title;
  Eigen::Isometry3d T_a_b;
};

/** Draws panels side by side as a PNG: each column of voxels a pixel block, the stronger the higher
 * the column (walls stand out from floors); map A orange, map B blue, both black; a bar of 5 m.
 * \exception std::runtime_error "<path>: <reason>". */
void drawTopView(const mrpt::fusion::OccupiedVoxels& a, const mrpt::fusion::OccupiedVoxels& b,
                 const std::vector<TopViewPanel>& panels, const std::string& path);
