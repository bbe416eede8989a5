// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fusion_core/map/map_voxels.h"
#include "fusion_octree/build.h"

/** \file
 * A coarse grid that scores many poses at once. */

namespace mrpt::fusion {

using Cell = std::array<int, 3>;  ///< Coordinates of a cell, in cells from the map's origin

/** A coarse copy of a map, of the octree's own cubes: whether an obstacle at a cell speaks for a
 * pose or against it. A cell beside an occupied one says nothing: quantisation puts many points of
 * a wall there. Dense, x fastest; beyond it all is unknown. */
class ScoreGrid {
 public:
  /** Sums of up to kMostSummed values keep both counts apart. */
  static constexpr uint16_t kUnknown = 0, kOccupied = 1, kFree = 256;
  static constexpr size_t kMostSummed = 255;

  /** Cells are the octree's cubes of 2^level voxels. */
  struct Layout {
    double cell;  ///< side, m
    unsigned level;

    Cell cellOf(const Eigen::Vector3d& p) const {
      return {static_cast<int>(std::floor(p.x() / cell)),
              static_cast<int>(std::floor(p.y() / cell)),
              static_cast<int>(std::floor(p.z() / cell))};
    }
    Cell cellOf(const octomap::OcTreeKey& key) const {
      const auto part = [this](octomap::key_type k) {
        return (k >> level) - (1 << (OcTreeCube::kMaxDepth - 1 - level));
      };
      return {part(key[0]), part(key[1]), part(key[2])};
    }
  };

  /** The part of \a map within \a region. */
  ScoreGrid(const MapVoxels& map, const Eigen::AlignedBox3d& region, const Layout& layout);

  /** The same with cells twice as wide: occupied if one in it is, free if all are, so that no
   * obstacle that confirms a pose is lost. */
  ScoreGrid coarser() const;

  Cell cellOf(const Eigen::Vector3d& p) const { return layout_.cellOf(p); }

  /** Sums of a row are padded to whole instructions. */
  static constexpr int kLanes = 8;
  static int padded(int length) { return (length + kLanes - 1) / kLanes * kLanes; }

  /** Adds the values of a box of cells, by rows along x of a padded length, y before z. What is
   * added to the rows' padding means nothing. */
  void addBox(const Cell& low, const Cell& size, uint16_t* __restrict sums) const;

 private:
  size_t cells() const {
    return static_cast<size_t>(size_[0]) * static_cast<size_t>(size_[1]) *
           static_cast<size_t>(size_[2]);
  }
  size_t index(int x, int y, int z) const {
    return (static_cast<size_t>(z) * static_cast<size_t>(size_[1]) + static_cast<size_t>(y)) *
               static_cast<size_t>(size_[0]) +
           static_cast<size_t>(x);
  }

  /** Free for now are all cells that have a free voxel. */
  void markFree(const OcTreeCube& cube);

  /** Sets the cells of a cube, as far as they are in the grid. */
  void mark(const Cell& cube, int side, uint16_t value);

  void clearBesideOccupied();

  Layout layout_;
  Cell low_{}, size_{};
  std::vector<uint16_t> values_;
};

}  // namespace mrpt::fusion
