// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Makes and reads outlines of maps. */
#include "fusion_link/outline.h"

#include <Eigen/Geometry>

#include "fusion_base/byte_reader.h"
#include "fusion_base/byte_writer.h"
#include "fusion_octree/compression.h"
#include "fusion_octree/resampling.h"
#include "fusion_octree/resolution.h"

namespace mrpt::fusion {
namespace {

/** Largest number of nodes of an outline that is read. */
constexpr size_t kMostOutlineNodes = 200'000;

}  // namespace

std::string outlineOf(const octomap::OcTree& map) {
  for (const double factor : {1., 2., 3., 4., 6., 8., 12., 16., 24., 32., 48., 64.}) {
    const double resolution = factor * map.getResolution();
    if (resolution > kMaxResolution) break;
    const auto coarse = transformOcTree(map, Eigen::Isometry3d::Identity(), resolution);
    coarse->toMaxLikelihood();
    coarse->prune();
    if (coarse->size() > kMostOutlineNodes) continue;
    std::string bytes;
    appendValue(resolution, bytes);
    bytes += compressNodes(*coarse, Packing::Smallest);
    if (bytes.size() <= kMostOutlineBytes) return bytes;
  }
  return {};
}

std::unique_ptr<octomap::OcTree> outlineFrom(std::string_view bytes) {
  ByteReader in(bytes);
  const auto resolution = in.take<double>();
  checkResolution(resolution);
  auto outline = std::make_unique<octomap::OcTree>(resolution);
  decompressNodes(in.takeBytes(in.size()), *outline, kMostOutlineNodes);
  return outline;
}

}  // namespace mrpt::fusion
