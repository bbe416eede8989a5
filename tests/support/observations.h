// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/poses/CPose3D.h>

#include <cmath>
#include <random>
#include <vector>

/** \file
 * Observations of the kinds that an octomap accepts.
 */

namespace map_tests {

/** The pose of a sensor on its robot. */
inline const mrpt::poses::CPose3D kSensorPose(0.37, -0.21, 1.13, 0.9, -0.35, 0.2);

/** Returns points on an uneven dome around a sensor, at 1 to 4 m. */
inline std::vector<mrpt::math::TPoint3Df> domePoints(unsigned seed, size_t count = 400) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> angle(-3.1F, 3.1F), height(-0.4F, 1.2F), range(1, 4);
  std::vector<mrpt::math::TPoint3Df> points;
  for (size_t i = 0; i < count; i++) {
    const float a = angle(rng), h = height(rng), r = range(rng);
    points.emplace_back(r * std::cos(a) * std::cos(h), r * std::sin(a) * std::cos(h),
                        r * std::sin(h));
  }
  return points;
}

/** Returns the depth image of a slanted surface. */
inline mrpt::obs::CObservation3DRangeScan::Ptr depthImage(const mrpt::poses::CPose3D& sensor) {
  auto obs = mrpt::obs::CObservation3DRangeScan::Create();
  obs->sensorPose = sensor;
  obs->hasRangeImage = true;
  obs->range_is_depth = true;
  obs->rangeUnits = 0.001F;
  obs->rangeImage_setSize(24, 32);
  obs->cameraParams.ncols = 32;
  obs->cameraParams.nrows = 24;
  obs->cameraParams.setIntrinsicParamsFromValues(30, 30, 15.5, 11.5);
  for (int r = 0; r < 24; r++)
    for (int c = 0; c < 32; c++)
      obs->rangeImage(r, c) = static_cast<uint16_t>(1500 + 20 * c + 13 * r);
  return obs;
}

inline mrpt::obs::CObservationPointCloud::Ptr cloudOf(
    const std::vector<mrpt::math::TPoint3Df>& points, const mrpt::poses::CPose3D& sensor = {}) {
  auto obs = mrpt::obs::CObservationPointCloud::Create();
  auto cloud = mrpt::maps::CSimplePointsMap::Create();
  for (const auto& p : points) cloud->insertPointFast(p.x, p.y, p.z);
  obs->pointcloud = cloud;
  obs->sensorPose = sensor;
  return obs;
}

inline mrpt::obs::CObservation3DRangeScan::Ptr scan3dOf(
    const std::vector<mrpt::math::TPoint3Df>& points, const mrpt::poses::CPose3D& sensor = {}) {
  auto obs = mrpt::obs::CObservation3DRangeScan::Create();
  obs->hasPoints3D = true;
  obs->resizePoints3DVectors(points.size());
  for (size_t i = 0; i < points.size(); i++) {
    obs->points3D_x[i] = points[i].x;
    obs->points3D_y[i] = points[i].y;
    obs->points3D_z[i] = points[i].z;
  }
  obs->sensorPose = sensor;
  return obs;
}

/** Returns a scan of a wavy wall, with some invalid beams. */
inline mrpt::obs::CObservation2DRangeScan::Ptr scan2d(const mrpt::poses::CPose3D& sensor = {}) {
  auto obs = mrpt::obs::CObservation2DRangeScan::Create();
  constexpr size_t kBeams = 181;
  obs->resizeScan(kBeams);
  obs->aperture = 3.0F;
  obs->maxRange = 20;
  obs->sensorPose = sensor;
  for (size_t i = 0; i < kBeams; i++) {
    obs->setScanRange(i, 3.0F + std::sin(0.13F * static_cast<float>(i)));
    obs->setScanRangeValidity(i, i % 11 != 3);
  }
  return obs;
}

}  // namespace map_tests
