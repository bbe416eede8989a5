// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/octomap_types.h>

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

/** \file
 * Point clouds as values, and their files. */

namespace mrpt::fusion {

/** The points of a file. */
struct PointCloud {
  std::vector<octomap::point3d> points;  ///< Points whose coordinates are finite, m
  size_t not_finite = 0;                 ///< Number of points that are left out
  /** Position of the sensor in the frame of the points, m, if the file states it. */
  std::optional<octomap::point3d> viewpoint;
  bool has_faces = false;  ///< True if the file is a mesh. Only its vertices are points

  /** Adds a point, m. */
  void add(double x, double y, double z);
};

/** True if the bytes begin like a `.pcd` or a `.ply` file.
 * \param[in] beginning First bytes of the file, see beginningOf(). */
bool isPointCloudFile(std::string_view beginning);

/** Reads the contents of a point cloud, which may be gzip data:
 *  - `.pcd` of PCL: ascii, binary and binary_compressed, coordinates of any type. VIEWPOINT is the
 *    position of the sensor. PCL writes `0 0 0 1 0 0 0` if it knows nothing of the sensor, so this
 *    VIEWPOINT states nothing;
 *  - `.ply`: ascii, little-endian and big-endian; the vertices are the points.
 *
 * Memory and time are proportional to the size of the file. A header that announces more points
 * than the file can hold is rejected before memory is taken.
 * \param[in] bytes The file.
 * \exception std::runtime_error If the header is wrong, the data is truncated or damaged, or
 * compressed data needs more memory than a file of its size can need. */
PointCloud parsePointCloud(std::string_view bytes);

}  // namespace mrpt::fusion
