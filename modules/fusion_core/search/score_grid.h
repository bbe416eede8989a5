// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fusion_base/whole_number.h"
#include "fusion_core/map/map_voxels.h"
#include "fusion_octree/build.h"

/** \file
 * A coarse grid that scores many poses at once. */

namespace mrpt::fusion {

using Cell = std::array<int, 3>;  ///< Coordinates of a cell, cells from the map's origin

/** A coarse copy of a map whose cells are cubes of the octree. The value of a cell is the effect of
 * an obstacle there on the score of a pose. Free cells beside occupied cells count as unknown,
 * because quantisation puts many points of a wall there. Dense, x fastest. All space outside is
 * unknown. */
class ScoreGrid {
 public:
  /** Values of cells. A sum of up to kMostSummed values holds both counts, one in each byte. */
  static constexpr uint16_t kUnknown = 0, kOccupied = 1, kFree = 256;
  static constexpr size_t kMostSummed = 255;

  /** Size of the cells: cubes of the octree with a side of 2^level voxels. */
  struct Layout {
    double cell;  ///< Side of a cell, m
    unsigned level;

    Cell cellOf(const Eigen::Vector3d& p) const {
      return {toWhole(std::floor(p.x() / cell)), toWhole(std::floor(p.y() / cell)),
              toWhole(std::floor(p.z() / cell))};
    }
    Cell cellOf(const octomap::OcTreeKey& key) const {
      const auto part = [this](octomap::key_type k) {
        return (k >> level) - (1 << (OcTreeCube::kMaxDepth - 1 - level));
      };
      return {part(key[0]), part(key[1]), part(key[2])};
    }
  };

  /** Copies the part of \a map within \a region. */
  ScoreGrid(const MapVoxels& map, const Eigen::AlignedBox3d& region, const Layout& layout);

  /** Returns the grid with cells twice as wide. A cell is occupied if it contains an occupied cell,
   * and free if all its cells are free. So no obstacle that confirms a pose is lost. */
  ScoreGrid coarser() const;

  Cell cellOf(const Eigen::Vector3d& p) const { return layout_.cellOf(p); }

  /** Number of values in a vector instruction. Rows of sums are padded to a multiple of it. */
  static constexpr int kLanes = 8;
  static int padded(int length) { return (length + kLanes - 1) / kLanes * kLanes; }

  /** Adds the values of a box of cells to \a sums, in rows along x of padded length, y before z.
   * The sums in the padding have no meaning. */
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

  /** Marks the cells with a free voxel as free. Occupied cells are marked later. */
  void markFree(const OcTreeCube& cube);

  /** Sets the cells of a cube that lie in the grid. */
  void mark(const Cell& cube, int side, uint16_t value);

  void clearBesideOccupied();

  Layout layout_;
  Cell low_{}, size_{};
  std::vector<uint16_t> values_;
};

}  // namespace mrpt::fusion
