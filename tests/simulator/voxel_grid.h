// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/octomap.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace mrpt::fusion::sim {

/** The occupied voxels of an OctoMap as a dense bit grid, made for casting many rays.
 *
 * Free and unknown space are alike transparent, and so is everything outside the grid.
 * Memory: one bit per voxel of the bounding box of the occupied voxels.
 */
class VoxelGrid {
 public:
  explicit VoxelGrid(const octomap::OcTree& tree);

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
  Eigen::Vector3i cellOf(const Eigen::Vector3d& point) const;
  bool at(const Eigen::Vector3i& cell) const;
  size_t index(const Eigen::Vector3i& cell) const;

  double voxelSize_;
  Eigen::Vector3d corner_ = Eigen::Vector3d::Zero();  // lowest corner of cell (0, 0, 0) [m]
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();    // cells along each axis
  std::vector<bool> bits_;
};

}  // namespace mrpt::fusion::sim
