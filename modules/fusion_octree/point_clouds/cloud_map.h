// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fusion_octree/point_clouds/point_cloud.h"

/** \file
 * Maps of point clouds. */

namespace mrpt::fusion {

/** How a point cloud becomes a map. */
struct CloudParams {
  double resolution = 0.1;  ///< Voxel size, m. The default is that of maps of recordings
  /** Position of the sensor in the frame of the points, m. Nothing: as the file states it. */
  std::optional<octomap::point3d> sensor_origin;
};

/** Makes a map of the points of one scan. A voxel with points gets one hit. If the position of the
 * sensor is known, all other voxels between the sensor and a point get one miss, see insertScan().
 * If it is not known, the map has no free space.
 *
 * Points outside of the octree's grid (2^15 voxels from its origin) are left out.
 * \param[in] cloud The points.
 * \param[in] origin Position of the sensor, m, frame of the points.
 * \param[in] resolution Voxel size, m.
 * \param[out] outside Number of points that are left out.
 * \return A pruned octree with OctoMap's default sensor model. Empty if there are no points.
 * \exception std::runtime_error If the resolution is not in [1e-4, 1e6] m, if the sensor is outside
 * of the grid, or if free space is out of proportion to the cloud: more than 4 million voxels and
 * 400 voxels per point.
 *
 * Cost: O(n log n) for n points, and with a sensor the voxels along all rays. */
std::unique_ptr<octomap::OcTree> octreeOf(const PointCloud& cloud,
                                          const std::optional<octomap::point3d>& origin,
                                          double resolution, size_t& outside);

/** Reads the contents of a point cloud as a map, see parsePointCloud() and octreeOf().
 * \param[in] bytes The file.
 * \param[in] params Parameters.
 * \param[out] notes Sentences about what differs from the file. May be null.
 * \exception std::runtime_error See parsePointCloud() and octreeOf(). */
std::unique_ptr<octomap::OcTree> parseCloudMap(std::string_view bytes, const CloudParams& params,
                                               std::vector<std::string>* notes = nullptr);

}  // namespace mrpt::fusion
