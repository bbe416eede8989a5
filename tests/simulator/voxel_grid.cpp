// SPDX-License-Identifier: BSD-3-Clause
#include "voxel_grid.h"

#include <cmath>
#include <limits>

namespace mrpt::fusion::sim {
namespace {

/** A cube of equal voxels: a leaf of the tree, which may be pruned. */
struct Cube {
  Eigen::Vector3i first;  // key of its lowest voxel
  int side;               // voxels along each edge
};

std::vector<Cube> occupiedCubes(const octomap::OcTree& tree) {
  std::vector<Cube> cubes;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    if (!tree.isNodeOccupied(*leaf)) continue;
    const octomap::OcTreeKey key = leaf.getIndexKey();
    cubes.push_back({{key[0], key[1], key[2]}, 1 << (tree.getTreeDepth() - leaf.getDepth())});
  }
  return cubes;
}

}  // namespace

VoxelGrid::VoxelGrid(const octomap::OcTree& tree) : voxelSize_(tree.getResolution()) {
  const std::vector<Cube> cubes = occupiedCubes(tree);
  if (cubes.empty()) return;

  Eigen::Vector3i low = cubes.front().first, high = low;
  for (const Cube& cube : cubes) {
    low = low.cwiseMin(cube.first);
    high = high.cwiseMax((cube.first.array() + cube.side).matrix());
  }
  const int keyOfZero = 1 << (tree.getTreeDepth() - 1);
  corner_ = (low.array() - keyOfZero).cast<double>() * voxelSize_;
  size_ = high - low;
  bits_.resize(size_.cast<size_t>().prod());

  for (const Cube& cube : cubes)
    for (int x = 0; x < cube.side; ++x)
      for (int y = 0; y < cube.side; ++y)
        for (int z = 0; z < cube.side; ++z)
          bits_[index(cube.first - low + Eigen::Vector3i(x, y, z))] = true;
}

VoxelGrid::VoxelGrid(double voxelSize, const Eigen::AlignedBox3d& extent) : voxelSize_(voxelSize) {
  // The rounding leaves a face where it is that is meant to be a multiple of the voxel size.
  const auto roundedDown = [&](const Eigen::Vector3d& point) -> Eigen::Vector3i {
    return (point.array() / voxelSize + 1e-6).floor().cast<int>();
  };
  const Eigen::Vector3i low = roundedDown(extent.min()), high = -roundedDown(-extent.max());
  corner_ = low.cast<double>() * voxelSize;
  size_ = high - low;
  bits_.resize(size_.cast<size_t>().prod());
}

void VoxelGrid::fill(const Eigen::AlignedBox3d& box) {
  forEachCellIn(box, [&](const Eigen::Vector3i& cell) { bits_[index(cell)] = true; });
}

void VoxelGrid::fillWhere(const Eigen::AlignedBox3d& box,
                          const std::function<bool(const Eigen::Vector3d&)>& inside) {
  forEachCellIn(box, [&](const Eigen::Vector3i& cell) {
    if (inside(centreOf(cell))) bits_[index(cell)] = true;
  });
}

void VoxelGrid::clear(const Eigen::AlignedBox3d& box) {
  forEachCellIn(box, [&](const Eigen::Vector3i& cell) { bits_[index(cell)] = false; });
}

bool VoxelGrid::anyOccupied(const Eigen::AlignedBox3d& box) const {
  bool any = false;
  forEachCellIn(box, [&](const Eigen::Vector3i& cell) { any = any || bits_[index(cell)]; });
  return any;
}

octomap::OcTree VoxelGrid::toOcTree() const {
  octomap::OcTree tree(voxelSize_);
  const Eigen::AlignedBox3d all(corner_, corner_ + size_.cast<double>() * voxelSize_);
  forEachCellIn(all, [&](const Eigen::Vector3i& cell) {
    if (!at(cell)) return;
    const Eigen::Vector3d centre = centreOf(cell);
    tree.setNodeValue(centre.x(), centre.y(), centre.z(), tree.getClampingThresMaxLog(), true);
  });
  tree.updateInnerOccupancy();
  tree.prune();
  return tree;
}

std::optional<double> VoxelGrid::castRay(const Eigen::Vector3d& origin,
                                         const Eigen::Vector3d& direction, double maxRange) const {
  Eigen::Vector3i cell = cellOf(origin);
  Eigen::Vector3i step;        // the way each axis counts its cells
  Eigen::Vector3d nextFace;    // range to the next face across each axis [m]
  Eigen::Vector3d faceToFace;  // range between two faces across each axis [m]
  for (int axis = 0; axis < 3; ++axis) {
    const double d = direction[axis];
    if (d == 0) {
      step[axis] = 0;
      nextFace[axis] = faceToFace[axis] = std::numeric_limits<double>::infinity();
      continue;
    }
    step[axis] = d > 0 ? 1 : -1;
    const double face = corner_[axis] + (cell[axis] + (d > 0 ? 1 : 0)) * voxelSize_;
    nextFace[axis] = (face - origin[axis]) / d;
    faceToFace[axis] = voxelSize_ / std::abs(d);
  }

  double range = 0;
  while (range <= maxRange) {
    if (at(cell)) return range;
    int axis;
    range = nextFace.minCoeff(&axis);
    nextFace[axis] += faceToFace[axis];
    cell[axis] += step[axis];
  }
  return std::nullopt;
}

template <typename Visitor>
void VoxelGrid::forEachCellIn(const Eigen::AlignedBox3d& box, Visitor visit) const {
  const Eigen::Array3d low = (box.min() - corner_).array() / voxelSize_ - 0.5;
  const Eigen::Array3d high = (box.max() - corner_).array() / voxelSize_ - 0.5;
  const Eigen::Array3i first = low.ceil().cast<int>().max(0);
  const Eigen::Array3i last = high.floor().cast<int>().min(size_.array() - 1);
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); ++x) visit(Eigen::Vector3i(x, y, z));
}

Eigen::Vector3d VoxelGrid::centreOf(const Eigen::Vector3i& cell) const {
  return corner_ + (cell.cast<double>().array() + 0.5).matrix() * voxelSize_;
}

Eigen::Vector3i VoxelGrid::cellOf(const Eigen::Vector3d& point) const {
  return ((point - corner_) / voxelSize_).array().floor().cast<int>();
}

bool VoxelGrid::at(const Eigen::Vector3i& cell) const {
  const bool inside = (cell.array() >= 0).all() && (cell.array() < size_.array()).all();
  return inside && bits_[index(cell)];
}

size_t VoxelGrid::index(const Eigen::Vector3i& cell) const {
  return (size_t(cell.z()) * size_.y() + cell.y()) * size_.x() + cell.x();
}

}  // namespace mrpt::fusion::sim
