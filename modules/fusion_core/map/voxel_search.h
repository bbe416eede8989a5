// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "fusion_core/map/voxel_blocks.h"

namespace mrpt::fusion {

/** Finds the nearest of many points that lie on a grid, or nearly one to a cell: it looks around
 * the place asked for, then as far as needed, and needs no walk down a tree. Building is O(n), a
 * query costs what lies within the distance of its answer. */
class VoxelSearch {
 public:
  /** \param[in] points Metres; must outlive the search. \param[in] cell Side of the grid's cells,
   * m; any, if not positive. Fastest where it is the grid of the points. */
  VoxelSearch(const std::vector<Eigen::Vector3f>& points, double cell);
  /** For the voxels of an octree, which are indexed already.
   * \param[in] voxels Their middles, m. \param[in] resolution Of the octree, m. \param[in] blocks
   * Of their keys, in the same order. All must outlive the search. */
  VoxelSearch(const std::vector<Eigen::Vector3f>& voxels, double resolution,
              const VoxelBlocks& blocks);
  VoxelSearch(const VoxelSearch&) = delete;
  VoxelSearch& operator=(const VoxelSearch&) = delete;

  /** Makes ready for queries up to a distance, m, on a coarser grid if need be: queries from there
   * tell of the others a little beyond it. Not while a query runs. */
  void prepare(double gate);
  /** The widest that has been prepared for, m; negative: none. */
  double gate() const { return gate_; }

  static constexpr uint32_t kNone = ~uint32_t{0};

  struct Nearest {
    uint32_t index = kNone;
    float distance;  ///< squared, with what \a extra adds, m^2
    /** All other points are at least as far by distance alone, squared, m^2. */
    float others = std::numeric_limits<float>::infinity();
  };
  /** The point of the least distance below best.distance; of two as near the one of lower index.
   * \param[in] best With what to begin: how far to look (squared, m^2; at most the gate prepared
   * for), and a point of that distance, if one is known.
   * \param[in] extra (index) -> what to add to a point's squared distance, m^2, not negative. */
  template <class Extra>
  Nearest nearest(const Eigen::Vector3f& p, Nearest best, Extra&& extra) const {
    const Eigen::Vector3f place = (p - low_) / cell_;
    if (!(place.cwiseAbs().maxCoeff() < kFarthestPlace)) {
      best.others = 0;  // none of them has been looked at
      return best;
    }
    const VoxelBlocks::Place at{floorOf(place.x()), floorOf(place.y()), floorOf(place.z())};
    if (best.index == kNone && !surroundings_.mayReach(at)) {
      best.others = rings_.back().sure;
      return best;
    }
    float squared_of_best = best.others;
    const auto compare = [&](uint32_t i) {
      const float squared = (points_[i] - p).squaredNorm(), d = squared + extra(i);
      if (i == best.index) {
        squared_of_best = squared;
      } else if (d < best.distance ||  // the gate itself is outside
                 (d == best.distance && i < best.index && best.index != kNone)) {
        best = {i, d, std::min(best.others, squared_of_best)};
        squared_of_best = squared;
      } else {
        best.others = std::min(best.others, squared);
      }
    };
    const auto look = [&](const Ring& ring) {
      blocks_->forEachAround(at, ring.ball, [&](uint32_t c, const VoxelBlocks::Offset&) {
        if (first_.empty()) return compare(c);
        for (uint32_t k = first_[c]; k < first_[c + 1]; k++) compare(point_[k]);
      });
    };
    look(rings_.front());
    const Ring* last = &rings_.front();
    if (best.distance >= last->sure) {
      // The narrowest that holds all that could be nearer still, and a little more: what is known
      // of the others then tells of places nearby, too.
      const float far = std::sqrt(best.distance) + kBeyond * cell_;
      size_t wide = 1;
      while (wide + 1 < rings_.size() && rings_[wide].sure <= far * far) wide++;
      if (wide < rings_.size()) look(*(last = &rings_[wide]));
    }
    best.others = std::min(best.others, last->sure);
    return best;
  }

 private:
  static constexpr float kBeyond = 0.25F;        // cells
  static constexpr float kFarthestPlace = 1e6F;  // cells; the grid has 2^16

  struct Ring {
    VoxelBlocks::Ball ball;  ///< the first is whole, the others are what lies beyond it
    float sure;              ///< points nearer than this (squared, m^2) lie within the radius
  };
  static int floorOf(float x) {
    const int i = static_cast<int>(x);
    return i - (x < static_cast<float>(i) ? 1 : 0);
  }

  void build(double cell);

  const std::vector<Eigen::Vector3f>& points_;
  Eigen::Vector3f low_ = Eigen::Vector3f::Zero();
  float cell_ = 1;
  double slack_ = 0;     // cells: how much nearer a point can be than its cell's offset is long
  double prepared_ = 0;  // the largest radius, cells
  double gate_ = -1;     // m
  VoxelBlocks own_;      // if none are given
  const VoxelBlocks* blocks_ = &own_;    // cells that hold points
  std::vector<uint32_t> first_, point_;  // the points of each cell; none: one in each, in order
  std::vector<Ring> rings_;
  VoxelBlocks::Surroundings surroundings_;  // as far as the last ring
};

}  // namespace mrpt::fusion
