// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "fusion_core/map/voxel_blocks.h"

/** \file
 * Search for the nearest voxel. */

namespace mrpt::fusion {

/** Finds the nearest of many points that lie on a grid, with about one point in each cell. A query
 * looks at the cells around its point, then as far as needed. It does not descend a tree.
 * Cost: O(n) to build; a query costs the number of points within the distance of its result. */
class VoxelSearch {
 public:
  /** \param[in] points Points, m; must outlive the search.
   * \param[in] cell Side of the cells of the grid, m. If not positive, the search chooses it. The
   * search is fastest with the grid of the points. */
  VoxelSearch(const std::vector<Eigen::Vector3f>& points, double cell);
  /** Uses an existing index of the voxels of an octree. All arguments must outlive the search.
   * \param[in] voxels Centres of the voxels, m.
   * \param[in] resolution Resolution of the octree, m.
   * \param[in] blocks Index of the keys of the voxels, in the same order. */
  VoxelSearch(const std::vector<Eigen::Vector3f>& voxels, double resolution,
              const VoxelBlocks& blocks);
  VoxelSearch(const VoxelSearch&) = delete;
  VoxelSearch& operator=(const VoxelSearch&) = delete;

  /** Prepares for queries up to a distance \a gate, m. A wide gate may need a coarser grid. The
   * bound Nearest::others then reaches a little beyond the gate. Must not be called during a
   * query. */
  void prepare(double gate);
  /** Largest prepared gate, m; negative: none. */
  double gate() const { return gate_; }

  static constexpr uint32_t kNone = ~uint32_t{0};

  struct Nearest {
    uint32_t index = kNone;
    float distance;  ///< Squared distance plus \a extra, m^2
    /** Lower bound on the squared distance, without extra, of all other points, m^2. */
    float others = std::numeric_limits<float>::infinity();
  };
  /** Returns the point of the least distance below best.distance. Of points at equal distance it
   * returns the point with the lower index.
   * \param[in] p The query point, m.
   * \param[in] best Start of the search: the largest distance (squared, m^2; at most the prepared
   * gate), and a point of that distance, if known.
   * \param[in] extra (index) -> addition to the point's squared distance, m^2, not negative. */
  template <class Extra>
  Nearest nearest(const Eigen::Vector3f& p, Nearest best, Extra&& extra) const {
    const Eigen::Vector3f place = (p - low_) / cell_;
    if (!(place.cwiseAbs().maxCoeff() < kFarthestPlace)) {
      best.others = 0;  // no point was compared
      return best;
    }
    const VoxelBlocks::Place at{floorOf(place.x()), floorOf(place.y()), floorOf(place.z())};
    if (best.index == kNone && !surroundings_.mayReach(at)) {
      best.others = rings_.back().complete_within;
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
    if (best.distance >= last->complete_within) {
      // The narrowest ring that holds all points that can be nearer, and a margin: the bound on the
      // other points is then useful at places nearby, too.
      const float far = std::sqrt(best.distance) + kBeyond * cell_;
      size_t wide = 1;
      while (wide + 1 < rings_.size() && rings_[wide].complete_within <= far * far) wide++;
      if (wide < rings_.size()) look(*(last = &rings_[wide]));
    }
    best.others = std::min(best.others, last->complete_within);
    return best;
  }

 private:
  static constexpr float kBeyond = 0.25F;        // margin, cells
  static constexpr float kFarthestPlace = 1e6F;  // cells; the grid has 2^16 along an axis

  struct Ring {
    VoxelBlocks::Ball ball;  ///< Cells of the ring; the first ring is a whole ball
    float complete_within;   ///< Squared distance below which all points lie in the ball, m^2
  };
  static int floorOf(float x) {
    const int i = static_cast<int>(x);
    return i - (x < static_cast<float>(i) ? 1 : 0);
  }

  void build(double cell);

  const std::vector<Eigen::Vector3f>& points_;
  Eigen::Vector3f low_ = Eigen::Vector3f::Zero();
  float cell_ = 1;
  double margin_ = 0;    // largest offset length minus distance of a point in a cell, cells
  double prepared_ = 0;  // largest prepared radius, cells
  double gate_ = -1;     // largest prepared gate, m
  VoxelBlocks own_;      // used if the caller gives no index
  const VoxelBlocks* blocks_ = &own_;    // index of the cells with points
  std::vector<uint32_t> first_, point_;  // points of each cell; empty: one point per cell
  std::vector<Ring> rings_;
  VoxelBlocks::Surroundings surroundings_;  // up to the radius of the last ring
};

}  // namespace mrpt::fusion
