// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/octomap.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <vector>

namespace mrpt::fusion::sim {

/** Occupied voxels as a dense bit grid, made for casting many rays.
 *
 * Free and unknown space are alike transparent, and so is everything outside the grid.
 * The faces of the voxels lie at multiples of the voxel size, as in an OctoMap.
 * Memory: one bit per voxel of the grid.
 */
class VoxelGrid {
 public:
  /** The occupied voxels of an OctoMap, and the bounding box of these. */
  explicit VoxelGrid(const octomap::OcTree& tree);

  /** An empty grid of at least `extent` [m]. */
  VoxelGrid(double voxelSize, const Eigen::AlignedBox3d& extent);

  /** Occupies the voxels of the grid whose centres lie in `box` [m]. */
  void fill(const Eigen::AlignedBox3d& box);

  /** Occupies those of them whose centres [m] satisfy `inside`. */
  void fillWhere(const Eigen::AlignedBox3d& box,
                 const std::function<bool(const Eigen::Vector3d&)>& inside);

  /** Frees the voxels whose centres lie in `box` [m]. */
  void clear(const Eigen::AlignedBox3d& box);

  /** Whether any voxel whose centre lies in `box` [m] is occupied. */
  bool anyOccupied(const Eigen::AlignedBox3d& box) const;

  /** The same as an OctoMap: occupied voxels, all else unknown. */
  octomap::OcTree toOcTree() const;

  double voxelSize() const { return voxelSize_; }  //!< [m]

  /** Whether the voxel that holds `point` [m] is occupied. */
  bool isOccupied(const Eigen::Vector3d& point) const { return at(cellOf(point)); }

  /** Distance [m] from `origin` [m] to the face where the ray enters its first occupied voxel.
   *
   * Visits each voxel on the way exactly once (Amanatides & Woo, 1987).
   * \param[in] direction Unit vector.
   * \param[in] maxRange Where the ray ends [m].
   * \return Nothing if the ray ends before; 0 if the origin itself is occupied.
   */
  std::optional<double> castRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                double maxRange) const;

 private:
  /** Calls `visit(cell)` for each cell of the grid whose centre lies in `box` [m]. */
  template <typename Visitor>
  void forEachCellIn(const Eigen::AlignedBox3d& box, Visitor visit) const;
  Eigen::Vector3d centreOf(const Eigen::Vector3i& cell) const;
  Eigen::Vector3i cellOf(const Eigen::Vector3d& point) const;
  bool at(const Eigen::Vector3i& cell) const;
  size_t index(const Eigen::Vector3i& cell) const;

  double voxelSize_;
  Eigen::Vector3d corner_ = Eigen::Vector3d::Zero();  // lowest corner of cell (0, 0, 0) [m]
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();    // cells along each axis
  std::vector<bool> bits_;
};

}  // namespace mrpt::fusion::sim
