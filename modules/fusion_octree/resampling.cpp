// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Resamples an octree on another grid. */
#include "fusion_octree/resampling.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include "fusion_octree/block_tree.h"
#include "fusion_octree/build.h"
#include "fusion_octree/resampler.h"
#include "fusion_octree/thin_obstacles.h"
#include "fusion_octree/walk.h"
#include "fusion_octree/work_budget.h"

namespace mrpt::fusion {
namespace {

using octomap::OcTree;

/** Returns the largest work for an octree, in voxels that are looked up. A tiny file can hold a
 * leaf with billions of voxels on its faces. The nodes of a map that was seen by a sensor need a
 * fraction of this work. */
uint64_t mostWorkFor(const OcTree& source, double resolution) {
  constexpr uint64_t kLeast = uint64_t{1} << 25U;  // 1 s, 250 MB
  // A node of the source meets few blocks of 4 x 4 x 4 new voxels, and more of them if the new
  // voxels are finer.
  constexpr double kPerBlock = 128, kFinest = 8;
  const double finer = std::clamp(source.getResolution() / resolution, 0.0, kFinest);
  const double per_node = kPerBlock * std::pow(1 + finer / 4, 3);
  return kLeast + static_cast<uint64_t>(per_node * static_cast<double>(source.size()));
}

/** Throws if the known space of \a source does not fit the new grid. */
void checkFits(const OcTree& source, const BlockTree& blocks, const Eigen::Isometry3d& T,
               double resolution) {
  const auto fits = [&](const Eigen::AlignedBox3d& known) {
    const Eigen::Vector3d centre = T * known.center();
    const Eigen::Vector3d half = T.linear().cwiseAbs() * (0.5 * known.sizes());
    return !((centre.cwiseAbs() + half).maxCoeff() > (kGridOrigin + 1e-6) * resolution);
  };
  if (blocks.empty() || fits(blocks.knownBlocks(source.getResolution()))) return;
  if (!fits(knownSpace(source)))
    throw std::out_of_range("the transformed map does not fit an octree of this resolution");
}

/** Looks up all of the new grid, in parts on all cores. */
CubeList resampledParts(const Resampler& resampler) {
  constexpr size_t kEnough = 64;  // number of parts: some are empty, some are full
  constexpr unsigned kDeepest = 12;
  std::vector<OcTreeCube> parts;
  for (unsigned depth = 1; parts.size() < kEnough && depth <= kDeepest; depth++)
    parts = Resampler(resampler).cubesAt(depth);
  std::vector<CubeList> lists(parts.size());
  tbb::parallel_for(size_t{0}, parts.size(),
                    [&](size_t i) { Resampler(resampler).resample(parts[i], lists[i]); });
  CubeList all;
  for (CubeList& list : lists) all.addAll(std::move(list));
  return all;
}

}  // namespace

CubeList resampledCubes(const OcTree& source, const Eigen::Isometry3d& T_dst_src,
                        double resolution) {
  if (!T_dst_src.matrix().allFinite())
    throw std::invalid_argument("transformOcTree: the transform is not finite");
  if (!(resolution > 0) || !std::isfinite(resolution))
    throw std::invalid_argument("transformOcTree: the resolution must be a positive length");
  constexpr double kMostCoarser = 64;  // the number of samples of a voxel grows with its cube
  if (resolution > kMostCoarser * source.getResolution())
    throw std::invalid_argument("transformOcTree: the new voxels are more than 64 times as wide");
  const BlockTree blocks(source);
  checkFits(source, blocks, T_dst_src, resolution);
  const WorkBudget budget(mostWorkFor(source, resolution));
  CubeList cubes = resampledParts(
      Resampler(blocks, T_dst_src.inverse(), source.getResolution(), resolution, budget));
  keepThinObstacles(source, blocks, T_dst_src, resolution, budget, cubes);
  return cubes;
}

std::unique_ptr<OcTree> transformOcTree(const OcTree& source, const Eigen::Isometry3d& T_dst_src,
                                        double resolution) {
  const CubeList cubes = resampledCubes(source, T_dst_src, resolution);
  auto result = std::make_unique<OcTree>(resolution);
  OcTreeAccess::setSensorModel(*result, OcTreeAccess::sensorModel(source));
  buildOcTreeInParallel(*result, CubeListVisitor(cubes));
  return result;
}

}  // namespace mrpt::fusion
