// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads point clouds. */

#include "fusion_octree/point_clouds/point_cloud.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "fusion_base/byte_reader.h"
#include "fusion_base/error_text.h"
#include "fusion_base/gzip.h"
#include "fusion_octree/file_budget.h"
#include "fusion_octree/point_clouds/formats.h"

namespace mrpt::fusion {
namespace {

PointCloud parsePlain(std::string_view bytes) {
  if (isPcd(bytes)) return withPath("point cloud (.pcd)", [&] { return parsePcd(bytes); });
  if (isPly(bytes)) return withPath("point cloud (.ply)", [&] { return parsePly(bytes); });
  corrupt("not a point cloud (.pcd or .ply)");
}

}  // namespace

void PointCloud::add(double x, double y, double z) {
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) {
    not_finite++;
    return;
  }
  constexpr double kMost = 1e30;  // m; beyond, a double may have no float
  const auto coordinate = [&](double v) {
    return static_cast<float>(std::clamp(v, -kMost, kMost));
  };
  points.emplace_back(coordinate(x), coordinate(y), coordinate(z));
}

bool isPointCloudFile(std::string_view beginning) { return isPcd(beginning) || isPly(beginning); }

PointCloud parsePointCloud(std::string_view bytes) {
  if (!isGzip(bytes)) return parsePlain(bytes);
  return parsePlain(gunzipped(bytes, FileBudget::of(bytes.size()).bytes));
}

}  // namespace mrpt::fusion
