// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Makes maps of point clouds. */

#include "fusion_octree/point_clouds/cloud_map.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <stdexcept>

#include "fusion_octree/build.h"
#include "fusion_octree/cube_list.h"
#include "fusion_octree/insertion/scan_insertion.h"
#include "fusion_octree/resolution.h"
#include "fusion_octree/walk.h"

namespace mrpt::fusion {
namespace {

using octomap::OcTree;
using octomap::OcTreeKey;
using octomap::point3d;

/** Returns the points in the grid of an octree. */
std::vector<point3d> pointsInGrid(const OcTree& tree, const std::vector<point3d>& points) {
  std::vector<point3d> inside;
  inside.reserve(points.size());
  OcTreeKey key;
  for (const point3d& p : points)
    if (keyAt(tree, p, key)) inside.push_back(p);
  return inside;
}

/** Returns the voxels of points that are in the grid, in the order of the octree, each once. */
std::vector<uint64_t> voxelsOf(const OcTree& tree, const std::vector<point3d>& points) {
  std::vector<uint64_t> voxels(points.size());
  std::transform(points.begin(), points.end(), voxels.begin(),
                 [&](const point3d& p) { return octreeOrder(tree.coordToKey(p)); });
  tbb::parallel_sort(voxels.begin(), voxels.end());
  voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
  return voxels;
}

/** Fills an empty octree with hits. \param[in] voxels The result of voxelsOf(). */
void addHits(const std::vector<uint64_t>& voxels, OcTree& tree) {
  CubeList list;
  for (auto voxel = voxels.begin(); voxel != voxels.end();) {
    constexpr uint64_t kInBlock = VoxelBlock::kVoxels - 1;
    const OcTreeCube cube{keyInOctreeOrder(*voxel & ~kInBlock), VoxelBlock::kDepth};
    VoxelBlock block;
    for (const uint64_t first = *voxel; voxel != voxels.end() && (*voxel ^ first) <= kInBlock;
         ++voxel)
      block.set(static_cast<unsigned>(*voxel & kInBlock), tree.getProbHitLog());
    list.addBlock(cube, block);
  }
  buildOcTreeInParallel(tree, CubeListVisitor(list));
}

/** Checks that the free space of a scan has a size that a cloud of its size can need. The bound is
 * the box of all rays or the sum of the rays to distinct voxels, whichever is smaller.
 * \exception std::runtime_error If it has not. */
void checkFreeSpace(const std::vector<uint64_t>& voxels, const OcTreeKey& origin, size_t points) {
  constexpr uint64_t kLeast = uint64_t{1} << 22U, kPerPoint = 400;
  const uint64_t most = std::max(kLeast, kPerPoint * points);
  std::array<int, 3> low{}, high{};
  uint64_t on_rays = 0;
  for (const uint64_t voxel : voxels) {
    const OcTreeKey end = keyInOctreeOrder(voxel);
    for (unsigned axis = 0; axis < 3; axis++) {
      const int step = int{end[axis]} - int{origin[axis]};
      low[axis] = std::min(low[axis], step);
      high[axis] = std::max(high[axis], step);
      on_rays += static_cast<uint64_t>(std::abs(step));
    }
  }
  uint64_t in_box = 1;  // at most 2^48
  for (unsigned axis = 0; axis < 3; axis++)
    in_box *= static_cast<uint64_t>(high[axis] - low[axis] + 1);
  if (std::min(on_rays, in_box) > most)
    throw std::runtime_error("the rays from the sensor cross up to " +
                             std::to_string(std::min(on_rays, in_box)) + " voxels, more than " +
                             std::to_string(most) + ": the voxels are too small");
}

std::string textOf(size_t count, const char* what) {
  return std::to_string(count) + (count == 1 ? " point " : " points ") + what;
}

/** Returns where the grid of a map ends, as the end of a sentence. */
std::string endOfGrid(double resolution) {
  char text[96];
  std::snprintf(text, sizeof(text), ", which ends %g m from the origin (32768 voxels of %g m)",
                32768 * resolution, resolution);
  return text;
}

}  // namespace

std::unique_ptr<OcTree> octreeOf(const PointCloud& cloud, const std::optional<point3d>& origin,
                                 double resolution, size_t& outside) {
  checkResolution(resolution);
  auto tree = std::make_unique<OcTree>(resolution);
  const auto points = pointsInGrid(*tree, cloud.points);
  outside = cloud.points.size() - points.size();
  const auto voxels = voxelsOf(*tree, points);
  if (!origin) {
    addHits(voxels, *tree);
    return tree;
  }
  OcTreeKey sensor;
  if (!keyAt(*tree, *origin, sensor))
    throw std::runtime_error("the sensor is outside of the grid of a map with such voxels");
  checkFreeSpace(voxels, sensor, points.size());
  constexpr double kWholeBeams = -1;
  insertScan(*tree, points, *origin, kWholeBeams, true, InnerNodes::Pruned);
  return tree;
}

std::unique_ptr<OcTree> parseCloudMap(std::string_view bytes, const CloudParams& params,
                                      std::vector<std::string>* notes) {
  const PointCloud cloud = parsePointCloud(bytes);
  const auto origin = params.sensor_origin ? params.sensor_origin : cloud.viewpoint;
  size_t outside = 0;
  auto tree = octreeOf(cloud, origin, params.resolution, outside);
  const std::string end = endOfGrid(params.resolution);
  if (outside > 0 && outside == cloud.points.size())
    throw std::runtime_error("all points are outside of the grid of the map" + end +
                             ": subtract an offset, or use larger voxels");
  if (!notes) return tree;
  const auto note = [&](const std::string& text) { notes->push_back(text); };
  if (cloud.not_finite > 0) note(textOf(cloud.not_finite, "without finite coordinates left out"));
  if (outside > 0)
    note(textOf(outside, "outside of the grid of the map left out") + end +
         ": are the lengths in m?");
  if (cloud.has_faces) note("is a mesh: only its vertices are used");
  if (!origin) note("the position of the sensor is not known: the map has no free space");
  return tree;
}

}  // namespace mrpt::fusion
