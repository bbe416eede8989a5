// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/search.h>
#include <mrpt/maps/octree_build.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "parallel.h"

namespace mrpt::fusion {
namespace {

using Cell = std::array<int, 3>;

/** A coarse copy of a map, of the octree's own cubes: whether an obstacle at a cell speaks for a
 * pose or against it. A cell beside an occupied one says nothing: quantisation puts many points of
 * a wall there. Dense, x fastest, with a margin of unknown cells so that shifted runs need no
 * bounds checks along x. */
class ScoreGrid {
 public:
  static constexpr int8_t kOccupied = 1, kUnknown = 0, kFree = -kConflictWeight;

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
        return (k >> level) - (1 << (mrpt::maps::OcTreeCube::kMaxDepth - 1 - level));
      };
      return {part(key[0]), part(key[1]), part(key[2])};
    }
  };

  /** The part of \a map within \a region. \param[in] a All of its occupied voxels. */
  ScoreGrid(const octomap::OcTree& map, const OccupiedVoxels& a, const Eigen::AlignedBox3d& region,
            const Layout& layout, int margin)
      : layout_(layout) {
    const Cell low = layout.cellOf(region.min()), high = layout.cellOf(region.max());
    for (unsigned axis = 0; axis < 3; axis++) {
      const int extra = axis == 0 ? margin : 1;
      low_[axis] = low[axis] - extra;
      size_[axis] = high[axis] + extra + 1 - low_[axis];
    }
    values_.assign(static_cast<size_t>(size_[0]) * static_cast<size_t>(size_[1]) *
                       static_cast<size_t>(size_[2]),
                   kUnknown);
    if (map.getRoot()) markKnown(map, *map.getRoot(), {});
    for (const auto& key : a.key) mark(layout.cellOf(key), 1, kOccupied);
    clearBesideOccupied();
  }

  Cell cellOf(const Eigen::Vector3d& p) const { return layout_.cellOf(p); }

  /** The run of \a length cells along x from a cell on; null if it leaves the grid (unknown). */
  const int8_t* run(int x, int y, int z, int length) const {
    x -= low_[0];
    y -= low_[1];
    z -= low_[2];
    if (x < 0 || x + length > size_[0] || y < 0 || y >= size_[1] || z < 0 || z >= size_[2])
      return nullptr;
    return &values_[index(x, y, z)];
  }

 private:
  size_t index(int x, int y, int z) const {
    return (static_cast<size_t>(z) * static_cast<size_t>(size_[1]) + static_cast<size_t>(y)) *
               static_cast<size_t>(size_[0]) +
           static_cast<size_t>(x);
  }

  /** Free for now are all cells of which anything is known. */
  void markKnown(const octomap::OcTree& map, const octomap::OcTreeNode& node,
                 const mrpt::maps::OcTreeCube& cube) {
    const unsigned height = cube.kMaxDepth - cube.depth;
    if (height <= layout_.level || !map.nodeHasChildren(&node)) {
      mark(layout_.cellOf(cube.key), 1 << (std::max(height, layout_.level) - layout_.level), kFree);
      return;
    }
    for (unsigned i = 0; i < 8; i++)
      if (map.nodeChildExists(&node, i)) markKnown(map, *map.getNodeChild(&node, i), cube.child(i));
  }

  /** Sets the cells of a cube, as far as they are in the grid. */
  void mark(const Cell& cube, int side, int8_t value) {
    Cell low, high;
    for (unsigned axis = 0; axis < 3; axis++) {
      low[axis] = std::max(cube[axis] - low_[axis], 0);
      high[axis] = std::min(cube[axis] - low_[axis] + side, size_[axis]);
    }
    for (int z = low[2]; z < high[2]; z++)
      for (int y = low[1]; y < high[1]; y++)
        for (int x = low[0]; x < high[0]; x++) values_[index(x, y, z)] = value;
  }

  void clearBesideOccupied() {
    const std::vector<int8_t> before = values_;
    for (int z = 1; z + 1 < size_[2]; z++)
      for (int y = 1; y + 1 < size_[1]; y++)
        for (int x = 1; x + 1 < size_[0]; x++) {
          if (before[index(x, y, z)] != kOccupied) continue;
          for (int dz = -1; dz <= 1; dz++)
            for (int dy = -1; dy <= 1; dy++)
              for (int dx = -1; dx <= 1; dx++) {
                int8_t& v = values_[index(x + dx, y + dy, z + dz)];
                v = std::max(v, kUnknown);
              }
        }
  }

  Layout layout_;
  Cell low_{}, size_{};
  std::vector<int8_t> values_;
};

/** The translations tried with one yaw, in cells. */
struct Window {
  Cell low, size;
};

/** A pose of the lattice: yaw in steps, translation in cells. */
struct Place {
  int32_t score;
  int yaw, x, y, z;

  int farness() const { return yaw * yaw + x * x + y * y + z * z; }
  bool isBetterThan(const Place& o) const {
    return score != o.score ? score > o.score : farness() < o.farness();  // near the guess first
  }
  bool isNear(const Place& o, int near_yaws) const {
    return std::abs(x - o.x) <= 3 && std::abs(y - o.y) <= 3 && std::abs(yaw - o.yaw) <= near_yaws;
  }
};

/** The score of each translation in the window, x fastest. */
std::vector<int32_t> scoreWindow(const ScoreGrid& grid, const Eigen::Isometry3d& T,
                                 const std::vector<Eigen::Vector3f>& points, const Window& window) {
  const auto& [low, size] = window;
  std::vector<int32_t> sums(static_cast<size_t>(size[0]) * static_cast<size_t>(size[1]) *
                            static_cast<size_t>(size[2]));
  // As many points at a time as cannot overflow a byte: sixteen places to an instruction.
  constexpr size_t kAtATime = 127 / kConflictWeight;
  std::vector<int8_t> some(sums.size());
  for (size_t first = 0; first < points.size(); first += kAtATime) {
    std::fill(some.begin(), some.end(), 0);
    for (size_t i = first; i < std::min(first + kAtATime, points.size()); i++) {
      const Cell c = grid.cellOf(T * points[i].cast<double>());
      int8_t* row = some.data();
      for (int z = 0; z < size[2]; z++)
        for (int y = 0; y < size[1]; y++, row += size[0])
          if (const int8_t* values =
                  grid.run(c[0] + low[0], c[1] + low[1] + y, c[2] + low[2] + z, size[0]))
            for (int x = 0; x < size[0]; x++) row[x] = static_cast<int8_t>(row[x] + values[x]);
    }
    for (size_t k = 0; k < sums.size(); k++) sums[k] += some[k];
  }
  return sums;
}

/** The best places, none near a better one, best first. */
std::vector<Place> mostDistinct(const std::vector<Place>& places, unsigned count, int near_yaws) {
  std::vector<Place> best;
  while (best.size() < count) {
    const Place* top = nullptr;
    for (const Place& p : places) {
      const bool near = std::any_of(best.begin(), best.end(),
                                    [&](const Place& t) { return p.isNear(t, near_yaws); });
      if (!near && (!top || p.isBetterThan(*top))) top = &p;
    }
    if (!top) break;
    best.push_back(*top);
  }
  return best;
}

std::vector<Place> bestPlaces(const std::vector<int32_t>& scores, const Window& window, int yaw,
                              unsigned count, int near_yaws) {
  std::vector<Place> places;
  places.reserve(scores.size());
  for (int z = 0, i = 0; z < window.size[2]; z++)
    for (int y = 0; y < window.size[1]; y++)
      for (int x = 0; x < window.size[0]; x++, i++)
        places.push_back({scores[static_cast<size_t>(i)], yaw, window.low[0] + x, window.low[1] + y,
                          window.low[2] + z});
  return mostDistinct(places, count, near_yaws);
}

Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p.cast<double>();
  return sum / static_cast<double>(std::max<size_t>(1, points.size()));
}

Eigen::AlignedBox3d boxOf(const OccupiedVoxels& voxels, const Eigen::Isometry3d& T) {
  Eigen::AlignedBox3d box;
  for (const auto& c : voxels.centre) box.extend(T * c.cast<double>());
  return box;
}

/** The part of map A where B's voxels can come to lie. */
Eigen::AlignedBox3d regionOf(const OccupiedVoxels& a, const OccupiedVoxels& b,
                             const Eigen::Isometry3d& T_a_b, const SearchParams& params) {
  Eigen::AlignedBox3d box_b = boxOf(b, T_a_b);
  // Turned by any angle it stays within its diagonal; the window reaches three translations.
  const double turn = params.yaw > 0 ? 0.5 * box_b.diagonal().head<2>().norm() : 0;
  const double reach = 3 * params.translation + turn;
  box_b.extend(box_b.min() - Eigen::Vector3d(reach, reach, 2 * params.height));
  box_b.extend(box_b.max() + Eigen::Vector3d(reach, reach, 2 * params.height));
  // Free space that is far from all obstacles tells no poses apart.
  Eigen::AlignedBox3d box_a = boxOf(a, Eigen::Isometry3d::Identity());
  const Eigen::Vector3d beside = Eigen::Vector3d::Constant(params.translation + params.height);
  box_a.extend(box_a.min() - beside);
  box_a.extend(box_a.max() + beside);
  const Eigen::AlignedBox3d common = box_a.intersection(box_b);
  return common.isEmpty() ? Eigen::AlignedBox3d(box_a.min(), box_a.min()) : common;
}

/** The cell's side: as asked for, at least two voxels, and so large that the grid stays small
 * however far apart the pieces of the maps lie; rounded up to a cube of A's octree. */
ScoreGrid::Layout layoutFor(double resolution_a, const OccupiedVoxels& b,
                            const Eigen::AlignedBox3d& region, const SearchParams& params) {
  constexpr double kMostCells = 64e6;
  const double least = std::max(
      {params.cell, 2 * resolution_a, 2 * b.resolution, std::cbrt(region.volume() / kMostCells)});
  ScoreGrid::Layout layout{resolution_a, 0};
  while (layout.cell < least * (1 - 1e-9)) {
    layout.cell *= 2;
    layout.level++;
  }
  return layout;
}

}  // namespace

std::vector<Hypothesis> searchAround(const octomap::OcTree& map_a, const OccupiedVoxels& a,
                                     const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                                     const SearchParams& params) {
  if (a.size() == 0 || b.size() == 0 || params.translation <= 0 || params.hypotheses == 0)
    return {};
  const Eigen::AlignedBox3d region = regionOf(a, b, T_a_b, params);
  const ScoreGrid::Layout layout = layoutFor(a.resolution, b, region, params);
  const double cell = layout.cell;
  const int reach = static_cast<int>(std::ceil(params.translation / cell));
  const int reach_z = static_cast<int>(std::ceil(params.height / cell));

  const std::vector<Eigen::Vector3f>& points = b.centre;
  const Eigen::Vector3d middle = T_a_b * meanOf(points);
  double radius = cell;
  for (const auto& p : points)
    radius = std::max(radius, (T_a_b * p.cast<double>() - middle).head<2>().norm());
  const double yaw_step = cell / radius;
  const int yaws = static_cast<int>(std::ceil(params.yaw / yaw_step));
  constexpr double kNearYaw = 10 * M_PI / 180;
  const int near_yaws = static_cast<int>(kNearYaw / yaw_step);

  // A guess that is wrong in yaw turned the map about the origin of B's frame as likely as about
  // its middle, which then lies elsewhere: the window of a yaw covers both.
  const Eigen::Vector3d lever = middle - T_a_b.translation();
  const auto windowOf = [&](int yaw) {
    const Eigen::Vector3d turned =
        Eigen::AngleAxisd(yaw * yaw_step, Eigen::Vector3d::UnitZ()) * lever - lever;
    Window w;
    for (int axis = 0; axis < 2; axis++) {
      const int shift =
          std::clamp(static_cast<int>(std::lround(turned[axis] / cell)), -2 * reach, 2 * reach);
      w.low[axis] = std::min(0, shift) - reach;
      w.size[axis] = std::max(0, shift) + reach + 1 - w.low[axis];
    }
    w.low[2] = -reach_z;
    w.size[2] = 2 * reach_z + 1;
    return w;
  };
  const auto rotated = [&](int yaw) {
    return Eigen::Isometry3d(Eigen::Translation3d(middle) *
                             Eigen::AngleAxisd(yaw * yaw_step, Eigen::Vector3d::UnitZ()) *
                             Eigen::Translation3d(-middle) * T_a_b);
  };

  const ScoreGrid grid(map_a, a, region, layout, 6 * reach + 2);
  std::vector<std::vector<Place>> best_of_yaw(static_cast<size_t>(2 * yaws + 1));
  forEachIndex(best_of_yaw.size(), 1, [&](size_t i) {
    const int yaw = static_cast<int>(i) - yaws;
    const Window window = windowOf(yaw);
    const auto scores = scoreWindow(grid, rotated(yaw), points, window);
    best_of_yaw[i] = bestPlaces(scores, window, yaw, params.hypotheses, near_yaws);
  });
  std::vector<Place> places;
  for (const auto& of_yaw : best_of_yaw) places.insert(places.end(), of_yaw.begin(), of_yaw.end());

  std::vector<Hypothesis> best;
  for (const Place& p : mostDistinct(places, params.hypotheses, near_yaws))
    best.push_back({Eigen::Translation3d(p.x * cell, p.y * cell, p.z * cell) * rotated(p.yaw),
                    static_cast<double>(p.score)});
  return best;
}

}  // namespace mrpt::fusion
