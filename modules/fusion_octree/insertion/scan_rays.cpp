// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The rays of a scan as octomap computes them. All arithmetic is that of octomap 1.9, in the same
 * precision and order, because a single different bit can change the voxels of a ray. The file is
 * compiled without contraction of products and sums. */

#include "fusion_octree/insertion/scan_rays.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace mrpt::fusion {
namespace {

/** Key of the frame's origin: half the number of the voxels of an axis. */
constexpr int32_t kCentre = 1 << 15;

/** Returns whether a coordinate, in voxels, is in the octree's grid. False if it is not a number.
 */
bool inGrid(double voxels) { return (voxels >= -kCentre) & (voxels < kCentre); }

/** Returns the key of a coordinate, in voxels, in the grid. As floor(), without a call. */
int32_t keyOf(double voxels) {
  const auto whole = static_cast<int32_t>(voxels);
  return whole - (static_cast<double>(whole) > voxels ? 1 : 0) + kCentre;
}

/** Shortens the rays that are longer than the maximal range. */
void limitRange(const octomap::point3d* ends, const octomap::point3d& origin, double max_range,
                RayChunk& chunk) {
  for (size_t i = 0; i < chunk.size; i++) {
    const octomap::point3d beam = ends[i] - origin;
    if (beam.norm() <= max_range) continue;
    const octomap::point3d end = origin + beam.normalized() * static_cast<float>(max_range);
    chunk.x[i] = end.x();
    chunk.y[i] = end.y();
    chunk.z[i] = end.z();
    chunk.hit[i] = 0;
  }
}

}  // namespace

RayOrigin::RayOrigin(const octomap::OcTree& tree, const octomap::point3d& origin)
    : point(origin), resolution(tree.getResolution()), factor(1. / resolution) {
  for (unsigned axis = 0; axis < 3; axis++) {
    const double voxels = factor * static_cast<double>(origin(axis));
    if (!inGrid(voxels)) {
      in_grid = false;
      continue;
    }
    key[axis] = keyOf(voxels);
    const double centre = tree.keyToCoord(static_cast<octomap::key_type>(key[axis]));
    const auto to_border_of_voxel = static_cast<double>(static_cast<float>(resolution * 0.5));
    const auto from = static_cast<double>(origin(axis));
    to_border[axis] = {(centre - to_border_of_voxel) - from, (centre + to_border_of_voxel) - from};
  }
}

void makeRays(const octomap::point3d* ends, size_t count, const RayOrigin& origin, double max_range,
              RayChunk& chunk) {
  chunk.size = count;
  for (size_t i = 0; i < count; i++) {
    chunk.x[i] = ends[i].x();
    chunk.y[i] = ends[i].y();
    chunk.z[i] = ends[i].z();
    chunk.hit[i] = 1;
  }
  if (!(max_range < 0)) limitRange(ends, origin.point, max_range, chunk);

  const double factor = origin.factor;
  const CellKey from = origin.key;
  const bool in_grid = origin.in_grid;
  const CellBox nothing;
  CellKey low = nothing.low, high = nothing.high;
  for (size_t i = 0; i < count; i++) {  // the compiler makes vectors of this loop
    const double x = factor * static_cast<double>(chunk.x[i]);
    const double y = factor * static_cast<double>(chunk.y[i]);
    const double z = factor * static_cast<double>(chunk.z[i]);
    const bool ok_x = inGrid(x), ok_y = inGrid(y), ok_z = inGrid(z), ok = ok_x & ok_y & ok_z;
    const CellKey key{keyOf(ok ? x : 0), keyOf(ok ? y : 0), keyOf(ok ? z : 0)};
    chunk.kx[i] = key[0];
    chunk.ky[i] = key[1];
    chunk.kz[i] = key[2];
    const int32_t steps =
        std::abs(key[0] - from[0]) + std::abs(key[1] - from[1]) + std::abs(key[2] - from[2]);
    chunk.steps[i] = (ok & in_grid) ? static_cast<uint32_t>(steps) : 0;
    chunk.hit[i] = ok ? chunk.hit[i] : uint8_t{0};
    for (unsigned axis = 0; axis < 3; axis++) {
      low[axis] = std::min(low[axis], ok ? key[axis] : nothing.low[axis]);
      high[axis] = std::max(high[axis], ok ? key[axis] : nothing.high[axis]);
    }
  }
  chunk.box = {low, high};
}

}  // namespace mrpt::fusion
