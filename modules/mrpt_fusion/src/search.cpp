// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/search.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "parallel.h"

namespace mrpt::fusion {
namespace {

using Cell = std::array<int, 3>;

/** A coarse copy of a map: whether an obstacle at a cell speaks for a pose or against it. A cell
 * beside an occupied one says nothing: quantisation puts many points of a wall there. Dense, x
 * fastest, with a margin of unknown cells so that shifted runs need no bounds checks along x. */
class ScoreGrid {
 public:
  static constexpr int8_t kOccupied = 1, kUnknown = 0, kFree = -kConflictWeight;

  /** The part of \a map within \a region. */
  ScoreGrid(const octomap::OcTree& map, const Eigen::AlignedBox3d& region, double cell, int margin)
      : cell_(cell) {
    for (int axis = 0; axis < 3; axis++) {
      const int extra = axis == 0 ? margin : 1;
      low_[axis] = static_cast<int>(std::floor(region.min()[axis] / cell)) - extra;
      size_[axis] =
          static_cast<int>(std::floor(region.max()[axis] / cell)) + extra + 1 - low_[axis];
    }
    values_.assign(static_cast<size_t>(size_[0]) * static_cast<size_t>(size_[1]) *
                       static_cast<size_t>(size_[2]),
                   kUnknown);
    for (const bool occupied : {false, true})
      for (auto it = map.begin_leafs(); it != map.end_leafs(); ++it)
        if (map.isNodeOccupied(*it) == occupied)
          fill(Eigen::Vector3d(it.getX(), it.getY(), it.getZ()), it.getSize(),
               occupied ? kOccupied : kFree);
    clearBesideOccupied();
  }

  Cell cellOf(const Eigen::Vector3d& p) const {
    return {static_cast<int>(std::floor(p.x() / cell_)),
            static_cast<int>(std::floor(p.y() / cell_)),
            static_cast<int>(std::floor(p.z() / cell_))};
  }

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

  void fill(const Eigen::Vector3d& centre, double side, int8_t value) {
    const Eigen::Vector3d inside = Eigen::Vector3d::Constant(0.499 * side);
    Cell low = cellOf(centre - inside), high = cellOf(centre + inside);
    for (unsigned axis = 0; axis < 3; axis++) {
      low[axis] = std::max(low[axis], low_[axis]);
      high[axis] = std::min(high[axis], low_[axis] + size_[axis] - 1);
    }
    for (int z = low[2]; z <= high[2]; z++)
      for (int y = low[1]; y <= high[1]; y++)
        for (int x = low[0]; x <= high[0]; x++)
          values_[index(x - low_[0], y - low_[1], z - low_[2])] = value;
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

  double cell_;
  Cell low_{}, size_{};
  std::vector<int8_t> values_;
};

/** The middles of a map's occupied voxels in each coarse cell; every so many-th of them if there
 * are more than it takes to tell poses apart. */
std::vector<Eigen::Vector3d> coarsePoints(const OccupiedVoxels& voxels, double cell) {
  constexpr size_t kEnough = 2000;
  struct Sum {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int n = 0;
  };
  std::map<Cell, Sum> cells;  // ordered: the same points in the same order on every run
  for (const auto& c : voxels.centre) {
    const Eigen::Vector3d p = c.cast<double>();
    Sum& s = cells[{static_cast<int>(std::floor(p.x() / cell)),
                    static_cast<int>(std::floor(p.y() / cell)),
                    static_cast<int>(std::floor(p.z() / cell))}];
    s.sum += p;
    s.n++;
  }
  std::vector<Eigen::Vector3d> points;
  const size_t stride = (cells.size() + kEnough - 1) / kEnough;
  size_t i = 0;
  for (const auto& [key, s] : cells)
    if (i++ % stride == 0) points.push_back(s.sum / s.n);
  return points;
}

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
                                 const std::vector<Eigen::Vector3d>& points, const Window& window) {
  const auto& [low, size] = window;
  std::vector<int32_t> sums(static_cast<size_t>(size[0]) * static_cast<size_t>(size[1]) *
                            static_cast<size_t>(size[2]));
  for (const auto& p : points) {
    const Cell c = grid.cellOf(T * p);
    int32_t* row = sums.data();
    for (int z = 0; z < size[2]; z++)
      for (int y = 0; y < size[1]; y++, row += size[0])
        if (const int8_t* values =
                grid.run(c[0] + low[0], c[1] + low[1] + y, c[2] + low[2] + z, size[0]))
          for (int x = 0; x < size[0]; x++) row[x] += values[x];
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

Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p;
  return sum / static_cast<double>(std::max<size_t>(1, points.size()));
}

/** The part of map A where B's voxels can come to lie. */
Eigen::AlignedBox3d regionOf(const octomap::OcTree& map_a, const OccupiedVoxels& b,
                             const Eigen::Isometry3d& T_a_b, const SearchParams& params) {
  Eigen::AlignedBox3d box_a, box_b;
  Eigen::Vector3d low, high;
  map_a.getMetricMin(low.x(), low.y(), low.z());
  map_a.getMetricMax(high.x(), high.y(), high.z());
  box_a.extend(low).extend(high);
  for (const auto& c : b.centre) box_b.extend(T_a_b * c.cast<double>());
  // Turned by any angle it stays within its diagonal; the window reaches three translations.
  const double turn = params.yaw > 0 ? 0.5 * box_b.diagonal().head<2>().norm() : 0;
  const double reach = 3 * params.translation + turn;
  box_b.extend(box_b.min() - Eigen::Vector3d(reach, reach, 2 * params.height));
  box_b.extend(box_b.max() + Eigen::Vector3d(reach, reach, 2 * params.height));
  const Eigen::AlignedBox3d common = box_a.intersection(box_b);
  return common.isEmpty() ? Eigen::AlignedBox3d(low, low) : common;
}

/** The cell's side: as asked for, at least two voxels, and so large that the grid stays small
 * however far apart the pieces of the maps lie. */
double cellFor(const octomap::OcTree& map_a, const OccupiedVoxels& b,
               const Eigen::Isometry3d& T_a_b, const SearchParams& params) {
  constexpr double kMostCells = 64e6;
  const double volume = regionOf(map_a, b, T_a_b, params).volume();
  return std::max(
      {params.cell, 2 * map_a.getResolution(), 2 * b.resolution, std::cbrt(volume / kMostCells)});
}

}  // namespace

std::vector<Hypothesis> searchAround(const octomap::OcTree& map_a, const OccupiedVoxels& b,
                                     const Eigen::Isometry3d& T_a_b, const SearchParams& params) {
  if (b.size() == 0 || map_a.size() == 0 || params.translation <= 0 || params.hypotheses == 0)
    return {};
  const double cell = cellFor(map_a, b, T_a_b, params);
  const int reach = static_cast<int>(std::ceil(params.translation / cell));
  const int reach_z = static_cast<int>(std::ceil(params.height / cell));

  const auto points = coarsePoints(b, cell);
  const Eigen::Vector3d middle = T_a_b * meanOf(points);
  double radius = cell;
  for (const auto& p : points) radius = std::max(radius, (T_a_b * p - middle).head<2>().norm());
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

  const ScoreGrid grid(map_a, regionOf(map_a, b, T_a_b, params), cell, 6 * reach + 2);
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
