// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CProbOctoMap: conversion from and to the 3-D occupancy grid of MRPT. */

#include <mrpt/fusion/voxels.h>
#include <mrpt/maps/COccupancyGridMap3D.h>
#include <mrpt/maps/CProbOctoMap.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>

#include "fusion_octree/build.h"
#include "fusion_octree/walk.h"

using namespace mrpt::fusion;
using namespace mrpt::maps;

namespace {

using Grid = COccupancyGridMap3D;

/** Number of steps of a cell per unit of log-odds. A cell holds the log-odds of being free. */
constexpr float kCellSteps = 16;

/** Fills an octree with the cells of a grid. */
class GridVisitor {
 public:
  struct State {};
  /** \param[in] cells The cells. \param[in] first Key of the first cell. */
  GridVisitor(const Grid::grid_t& cells, const std::array<int64_t, 3>& first)
      : cells_(cells),
        first_(first),
        size_{static_cast<int64_t>(cells.getSizeX()), static_cast<int64_t>(cells.getSizeY()),
              static_cast<int64_t>(cells.getSizeZ())} {}

  OcTreeFill visit(const OcTreeCube& cube, const State&) const {
    std::array<int64_t, 3> c{};
    for (unsigned axis = 0; axis < 3; axis++) {
      c[axis] = cube.key[axis] - first_[axis];
      if (c[axis] + cube.side() <= 0 || c[axis] >= size_[axis]) return OcTreeFill::unknown();
    }
    if (cube.depth < OcTreeCube::kMaxDepth) return OcTreeFill::split();
    // In a grid that was read from a stream, MRPT does not set the stride, so cellByIndex() returns
    // wrong cells.
    const auto cell =
        cells_.data()[static_cast<size_t>(c[0] + size_[0] * (c[1] + size_[1] * c[2]))];
    return cell ? OcTreeFill::leaf(-static_cast<float>(cell) / kCellSteps) : OcTreeFill::unknown();
  }
  State descend(const State&, unsigned, const OcTreeCube&) const { return {}; }

 private:
  const Grid::grid_t& cells_;
  std::array<int64_t, 3> first_, size_;
};

/** The box of the known voxels of a tree: lowest and highest keys. */
struct KeyBox {
  std::array<uint32_t, 3> low{UINT32_MAX, UINT32_MAX, UINT32_MAX}, high{0, 0, 0};

  explicit KeyBox(const octomap::OcTree& tree) {
    forEachLeaf(tree, [&](const OcTreeCube& cube, const octomap::OcTreeNode&) {
      for (unsigned axis = 0; axis < 3; axis++) {
        low[axis] = std::min<uint32_t>(low[axis], cube.key[axis]);
        high[axis] = std::max<uint32_t>(high[axis], cube.key[axis] + cube.side() - 1);
      }
    });
  }
  double voxels() const {
    double n = 1;
    for (unsigned axis = 0; axis < 3; axis++) n *= high[axis] - low[axis] + 1.0;
    return n;
  }
};

/** Sets the protected field that says whether a grid is empty. MRPT only sets it when observations
 * are inserted. */
struct GridAccess : Grid {
  static void setEmpty(Grid& grid, bool empty) { grid.*(&GridAccess::m_is_empty) = empty; }
};

}  // namespace

CProbOctoMap::CProbOctoMap(const COccupancyGridMap3D& o) : CProbOctoMap() { fromOccupancyGrid(o); }

void CProbOctoMap::fromOccupancyGrid(const COccupancyGridMap3D& o) {
  const auto& cells = o.m_grid;
  const double resolution = cells.getResolutionXY();
  ASSERTMSG_(resolution > 0 && cells.getResolutionZ() == resolution,
             "CProbOctoMap: the cells of the grid are not cubes");
  constexpr double kOrigin = 32768;
  const std::array<double, 3> min{cells.getXMin(), cells.getYMin(), cells.getZMin()};
  const std::array<size_t, 3> size{cells.getSizeX(), cells.getSizeY(), cells.getSizeZ()};
  std::array<int64_t, 3> first{};
  for (unsigned axis = 0; axis < 3; axis++) {
    const double key = std::round(min[axis] / resolution) + kOrigin;
    ASSERTMSG_(key >= 0 && key + static_cast<double>(size[axis]) <= 2 * kOrigin,
               "CProbOctoMap: the grid is larger than an octree of its resolution");
    first[axis] = static_cast<int64_t>(key);
  }
  ASSERTMSG_(cells.data().size() == size[0] * size[1] * size[2],
             "CProbOctoMap: the number of cells does not fit the size of the grid");
  auto tree = std::make_unique<octomap::OcTree>(resolution);
  GridVisitor visitor(cells, first);
  buildOcTree(*tree, {}, visitor);
  OcTreeAccess::setSensorModel(*tree, OcTreeAccess::sensorModel(*m_octree));
  replaceTree(std::move(tree));
}

void CProbOctoMap::toOccupancyGrid(COccupancyGridMap3D& o) const {
  const double side = getResolution();
  if (isEmpty()) {
    o.setSize({0, 0, 0}, {side, side, side}, side);
    GridAccess::setEmpty(o, true);
    return;
  }
  const KeyBox box(*m_octree);
  ASSERTMSG_(box.voxels() <= static_cast<double>(kMaxVoxels),
             mrpt::format("CProbOctoMap: a grid of this map would have %.0f cells, more than %zu",
                          box.voxels(), kMaxVoxels));
  const auto corner = [&](const std::array<uint32_t, 3>& key, double voxels) {
    const auto coord = [&](unsigned axis) {
      return m_octree->keyToCoord(static_cast<octomap::key_type>(key[axis])) + voxels * side;
    };
    return mrpt::math::TPoint3D(coord(0), coord(1), coord(2));
  };
  o.setSize(corner(box.low, -0.5), corner(box.high, 0.5), side);
  GridAccess::setEmpty(o, false);
  forEachLeaf(*m_octree, [&](const OcTreeCube& cube, const octomap::OcTreeNode& node) {
    const float steps = std::clamp<float>(std::round(-kCellSteps * node.getLogOdds()),
                                          Grid::CELLTYPE_MIN, Grid::CELLTYPE_MAX);
    forEachVoxel(cube, [&](const octomap::OcTreeKey& key) {
      *o.m_grid.cellByIndex(key[0] - box.low[0], key[1] - box.low[1], key[2] - box.low[2]) =
          static_cast<Grid::voxelType>(steps);
    });
  });
}
