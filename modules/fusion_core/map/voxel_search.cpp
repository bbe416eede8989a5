// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Builds the grid and the balls of the nearest-voxel search. */
#include "fusion_core/map/voxel_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace mrpt::fusion {

namespace {
constexpr double kKeys = 65536;  // number of keys along an axis
constexpr double kRounding = 1e-2;

/** Largest difference between the length of a cell's offset and the distance of a point in the
 * cell, cells. \a off_centre is the largest distance of a point from the centre of its cell,
 * cells. */
double marginOf(double off_centre) { return std::sqrt(0.75) + off_centre + kRounding; }
}  // namespace

VoxelSearch::VoxelSearch(const std::vector<Eigen::Vector3f>& points, double cell)
    : points_(points) {
  build(cell);
}

VoxelSearch::VoxelSearch(const std::vector<Eigen::Vector3f>& voxels, double resolution,
                         const VoxelBlocks& blocks)
    : points_(voxels),
      cell_(static_cast<float>(resolution)),
      margin_(marginOf(kRounding)),
      blocks_(&blocks) {
  low_.setConstant(static_cast<float>(-0.5 * kKeys * resolution));
}

void VoxelSearch::build(double cell) {
  const std::vector<Eigen::Vector3f>& points = points_;
  rings_.clear();
  first_.clear();
  point_.clear();
  if (points.empty()) return;
  Eigen::Vector3f high = points[0];
  low_ = points[0];
  for (const auto& p : points) {
    low_ = low_.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double extent = (high - low_).cast<double>().maxCoeff();
  if (!(cell > 0)) cell = std::max(extent / std::cbrt(static_cast<double>(points.size())), 1e-6);
  cell = std::max(cell, extent / (kKeys - 2));
  cell_ = static_cast<float>(cell);
  const auto origin = static_cast<float>(0.5 * kKeys * cell);
  if (low_.minCoeff() >= -origin && high.maxCoeff() < origin)
    low_.setConstant(-origin);  // voxels of an octree keep their keys, and so their order
  else
    low_ -= Eigen::Vector3f::Constant(0.5F * cell_);

  std::vector<octomap::OcTreeKey> keys(points.size());
  float off_centre = 0;
  for (size_t i = 0; i < points.size(); i++) {
    const Eigen::Vector3f place = (points[i] - low_) / cell_;
    for (unsigned axis = 0; axis < 3; axis++)
      keys[i][axis] = static_cast<octomap::key_type>(floorOf(place[axis]));
    const Eigen::Vector3f centre(keys[i][0] + 0.5F, keys[i][1] + 0.5F, keys[i][2] + 0.5F);
    off_centre = std::max(off_centre, (place - centre).squaredNorm());
  }
  margin_ = marginOf(std::sqrt(off_centre));

  std::vector<uint64_t> order(points.size());
  std::transform(keys.begin(), keys.end(), order.begin(), octreeOrder);
  // The first two points that are not in the order of the octree, or share a cell.
  const auto together =
      std::adjacent_find(order.begin(), order.end(), std::greater_equal<uint64_t>());
  if (together == order.end()) {
    own_ = VoxelBlocks(keys);
    blocks_ = &own_;
    return;
  }
  point_.resize(points.size());
  std::iota(point_.begin(), point_.end(), 0);
  std::stable_sort(point_.begin(), point_.end(),
                   [&](uint32_t i, uint32_t j) { return order[i] < order[j]; });
  std::vector<octomap::OcTreeKey> cells;
  for (uint32_t k = 0; k < point_.size(); k++)
    if (k == 0 || order[point_[k]] != order[point_[k - 1]]) {
      cells.push_back(keys[point_[k]]);
      first_.push_back(k);
    }
  first_.push_back(static_cast<uint32_t>(point_.size()));
  own_ = VoxelBlocks(cells);
  blocks_ = &own_;
}

void VoxelSearch::prepare(double gate) {
  if (gate <= gate_) return;
  gate_ = gate;
  constexpr double kBeside = 1.8;  // the 26 cells around a cell: they hold most results
  // A fine grid has too many empty cells within a wide gate.
  constexpr double kMostCells = 12;
  if (gate > kMostCells * cell_) build(gate / kMostCells);
  constexpr double kGrowth = 1.75;  // so the second ball reaches the least gate, 2 cells
  const double radius = gate / cell_ + kBeyond + margin_;
  if (!rings_.empty() && prepared_ >= radius) return;
  while (rings_.empty() || prepared_ < radius) {
    const double next = rings_.empty() ? kBeside : std::min(kGrowth * prepared_, radius);
    const double complete_within = std::max(0.0, next - margin_) * cell_;
    rings_.push_back({VoxelBlocks::Ball(next, rings_.empty() ? -1 : kBeside),
                      static_cast<float>(complete_within * complete_within)});
    prepared_ = next;
  }
  surroundings_ = VoxelBlocks::Surroundings(*blocks_, prepared_);
}

}  // namespace mrpt::fusion
