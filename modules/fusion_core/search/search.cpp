// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/search/search.h"

#include <mrpt/fusion/voxels.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>

#include "fusion_base/parallel.h"
#include "fusion_octree/build.h"
#include "fusion_octree/resampling.h"

namespace mrpt::fusion {
namespace {

using Cell = std::array<int, 3>;

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
  ScoreGrid(const MapVoxels& map, const Eigen::AlignedBox3d& region, const Layout& layout)
      : layout_(layout) {
    const Cell low = layout.cellOf(region.min()), high = layout.cellOf(region.max());
    for (unsigned axis = 0; axis < 3; axis++) {
      low_[axis] = low[axis] - 1;
      size_[axis] = high[axis] + 2 - low_[axis];
    }
    values_.assign(cells() + kLanes, kUnknown);  // a run's padding may lie beyond the last row
    map.free.forEachCube(layout.level, [this](const OcTreeCube& cube) { markFree(cube); });
    for (const auto& key : map.voxels.key) mark(layout.cellOf(key), 1, kOccupied);
    clearBesideOccupied();
  }

  /** The same with cells twice as wide: occupied if one in it is, free if all are, so that no
   * obstacle that confirms a pose is lost. */
  ScoreGrid coarser() const {
    ScoreGrid c(*this);
    c.layout_ = {2 * layout_.cell, layout_.level + 1};
    for (unsigned axis = 0; axis < 3; axis++) {
      c.low_[axis] = low_[axis] >> 1;
      c.size_[axis] = ((low_[axis] + size_[axis] - 1) >> 1) + 1 - c.low_[axis];
    }
    c.values_.assign(c.cells() + kLanes,
                     kFree);  // the outermost cells are unknown, and make theirs so
    for (int z = 0; z < size_[2]; z++)
      for (int y = 0; y < size_[1]; y++)
        for (int x = 0; x < size_[0]; x++) {
          uint16_t& v =
              c.values_[c.index(((low_[0] + x) >> 1) - c.low_[0], ((low_[1] + y) >> 1) - c.low_[1],
                                ((low_[2] + z) >> 1) - c.low_[2])];
          v = lessAgainst(v, values_[index(x, y, z)]);
        }
    return c;
  }

  Cell cellOf(const Eigen::Vector3d& p) const { return layout_.cellOf(p); }

  /** Sums of a row are padded to whole instructions. */
  static constexpr int kLanes = 8;
  static int padded(int length) { return (length + kLanes - 1) / kLanes * kLanes; }

  /** Adds the values of a box of cells, by rows along x of a padded length, y before z; what is
   * else added to the rows' padding means nothing. */
  void addBox(const Cell& low, const Cell& size, uint16_t* __restrict sums) const {
    const int row_length = padded(size[0]);
    const int x = low[0] - low_[0], y = low[1] - low_[1], z = low[2] - low_[2];
    const int first_y = std::max(0, -y), end_y = std::min(size[1], size_[1] - y);
    const int first_x = std::max(0, -x), end_x = std::min(size[0], size_[0] - x);
    const bool whole_rows = first_x == 0 && end_x == size[0];
    if (first_x >= end_x) return;
    for (int k = std::max(0, -z); k < std::min(size[2], size_[2] - z); k++)
      for (int j = first_y; j < end_y; j++) {
        const uint16_t* __restrict values = &values_[index(x + first_x, y + j, z + k)];
        uint16_t* __restrict row = sums + (k * size[1] + j) * row_length;
        if (whole_rows) {
          for (int i = 0; i < row_length; i += kLanes)
            for (int lane = 0; lane < kLanes; lane++)
              row[i + lane] = static_cast<uint16_t>(row[i + lane] + values[i + lane]);
        } else {
          row += first_x;
          for (int i = 0; i < end_x - first_x; i++)
            row[i] = static_cast<uint16_t>(row[i] + values[i]);
        }
      }
  }

 private:
  static uint16_t lessAgainst(uint16_t v, uint16_t w) {
    if (v == kOccupied || w == kOccupied) return kOccupied;
    return std::min(v, w);
  }
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
  void markFree(const OcTreeCube& cube) {
    const unsigned level = std::max(cube.kMaxDepth - cube.depth, layout_.level);
    mark(layout_.cellOf(cube.key), 1 << (level - layout_.level), kFree);
  }

  /** Sets the cells of a cube, as far as they are in the grid. */
  void mark(const Cell& cube, int side, uint16_t value) {
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
    const std::vector<uint16_t> before = values_;
    for (int z = 1; z + 1 < size_[2]; z++)
      for (int y = 1; y + 1 < size_[1]; y++)
        for (int x = 1; x + 1 < size_[0]; x++) {
          if (before[index(x, y, z)] != kOccupied) continue;
          for (int dz = -1; dz <= 1; dz++)
            for (int dy = -1; dy <= 1; dy++)
              for (int dx = -1; dx <= 1; dx++) {
                uint16_t& v = values_[index(x + dx, y + dy, z + dz)];
                v = lessAgainst(v, kUnknown);
              }
        }
  }

  Layout layout_;
  Cell low_{}, size_{};
  std::vector<uint16_t> values_;
};

/** The translations tried with one yaw, in cells. */
struct Window {
  Cell low, size;

  size_t cells() const {
    return static_cast<size_t>(size[0]) * static_cast<size_t>(size[1]) *
           static_cast<size_t>(size[2]);
  }
};

/** A pose of a lattice: yaw in steps, translation in cells. */
struct Place {
  float score;
  int yaw, x, y, z;

  int64_t farness() const {
    const auto square = [](int64_t v) { return v * v; };
    return square(yaw) + square(x) + square(y) + square(z);
  }
  bool isBetterThan(const Place& o) const {  // of those as good those near the guess
    if (score != o.score) return score > o.score;
    return std::make_tuple(farness(), yaw, x, y, z) <
           std::make_tuple(o.farness(), o.yaw, o.x, o.y, o.z);
  }
};

/** Places this near to each other lead to the same pose. */
struct Near {
  int cells, yaws, turn;  // all the way round, in steps of yaw

  bool operator()(const Place& a, const Place& b) const {
    const int apart = std::abs(a.yaw - b.yaw);
    return std::abs(a.x - b.x) <= cells && std::abs(a.y - b.y) <= cells &&
           std::min(apart, std::abs(turn - apart)) <= yaws;
  }
};

/** The poses to try: turned about A's vertical through a point by whole steps, then moved by whole
 * cells. Each level's cells and steps are twice as wide as those of the level before. */
struct Lattice {
  Eigen::Isometry3d T_a_b;
  Eigen::Vector3d middle;  ///< in A's frame
  double cell, yaw_step;

  Lattice level(unsigned l) const {
    return {T_a_b, middle, std::ldexp(cell, static_cast<int>(l)),
            std::ldexp(yaw_step, static_cast<int>(l))};
  }
  Eigen::Isometry3d turned(int yaw) const {
    return Eigen::Isometry3d(Eigen::Translation3d(middle) *
                             Eigen::AngleAxisd(yaw * yaw_step, Eigen::Vector3d::UnitZ()) *
                             Eigen::Translation3d(-middle) * T_a_b);
  }
  Eigen::Isometry3d at(const Place& p) const {
    return Eigen::Translation3d(p.x * cell, p.y * cell, p.z * cell) * turned(p.yaw);
  }
};

using Points = std::vector<Eigen::Vector3f>;
using Normals = std::vector<Eigen::Vector3f>;

/** Confirmed obstacles count the less the more lie in free space beside them: where rooms or
 * pillars repeat, a larger overlap would win over the right one. A tenth of them leaves a fifth. */
float scoreOf(uint32_t confirmed, uint32_t conflicting) {
  if (confirmed == 0) return 0;
  constexpr float kConflictWeight = 10;
  const auto n = static_cast<float>(confirmed);
  const float share = n / (n + kConflictWeight * static_cast<float>(conflicting));
  return n * share * share;
}

/** The grid's cells of points. */
std::vector<Cell> cellsOf(const ScoreGrid& grid, const Points& points, const Eigen::Isometry3d& T) {
  std::vector<Cell> cells(points.size());
  for (size_t i = 0; i < points.size(); i++) cells[i] = grid.cellOf(T * points[i].cast<double>());
  return cells;
}

/** The places of one yaw, of each x and y the best height: all others are near it.
 * \param[in] scene The cells of the points, turned by the yaw. */
std::vector<Place> scoreWindow(const ScoreGrid& grid, const std::vector<Cell>& scene, int yaw,
                               const Window& window) {
  const auto& [low, size] = window;
  struct Counts {
    uint32_t occupied = 0, free = 0;
  };
  const int row_length = ScoreGrid::padded(size[0]);
  const size_t rows = static_cast<size_t>(size[1]) * static_cast<size_t>(size[2]);
  std::vector<Counts> counts(rows * static_cast<size_t>(row_length));
  std::vector<uint16_t> some(counts.size());
  for (size_t first = 0; first < scene.size(); first += ScoreGrid::kMostSummed) {
    std::fill(some.begin(), some.end(), 0);
    for (size_t i = first; i < std::min(first + ScoreGrid::kMostSummed, scene.size()); i++) {
      const auto& [x, y, z] = scene[i];
      grid.addBox({x + low[0], y + low[1], z + low[2]}, size, some.data());
    }
    for (size_t k = 0; k < counts.size(); k++) {
      counts[k].occupied += some[k] & 255U;
      counts[k].free += some[k] >> 8U;
    }
  }

  if (window.cells() == 0) return {};
  constexpr float kWorseThanAny = -1;
  std::vector<Place> best(static_cast<size_t>(size[0]) * static_cast<size_t>(size[1]),
                          {kWorseThanAny, yaw, 0, 0, 0});
  const Counts* row = counts.data();
  for (int z = 0; z < size[2]; z++) {
    auto column = best.begin();
    for (int y = 0; y < size[1]; y++, row += row_length)
      for (int x = 0; x < size[0]; x++, column++) {
        const Place place{scoreOf(row[x].occupied, row[x].free), yaw, low[0] + x, low[1] + y,
                          low[2] + z};
        if (place.isBetterThan(*column)) *column = place;
      }
  }
  return best;
}

/** The best places, none near a better one, best first. */
std::vector<Place> mostDistinct(std::vector<Place> places, size_t count, const Near& near) {
  const auto better = [](const Place& a, const Place& b) { return a.isBetterThan(b); };
  std::vector<Place> best;
  auto sorted = places.begin();
  for (size_t next = 64 * count; best.size() < count && sorted != places.end(); next *= 4) {
    const auto end =
        sorted + std::min(static_cast<std::ptrdiff_t>(next), std::distance(sorted, places.end()));
    std::nth_element(sorted, end - 1, places.end(), better);
    std::sort(sorted, end, better);
    for (; sorted != end && best.size() < count; sorted++)
      if (std::none_of(best.begin(), best.end(), [&](const Place& b) { return near(*sorted, b); }))
        best.push_back(*sorted);
    sorted = end;
  }
  return best;
}

Eigen::AlignedBox3d boxOf(const Points& points, const Eigen::Isometry3d& T) {
  Eigen::AlignedBox3d box;
  for (const auto& p : points) box.extend(T * p.cast<double>());
  return box;
}

/** The box without the outermost voxels, one of 200 along each axis and to each side: stray returns
 * lie far from a map, and tell nothing of where another can lie. */
Eigen::AlignedBox3d boxOfMost(const OccupiedVoxels& voxels) {
  Eigen::AlignedBox3d box;
  const size_t stray = voxels.key.size() / 200;
  if (voxels.key.empty()) return box;
  for (unsigned axis = 0; axis < 3; axis++) {
    const auto [first, last] =
        std::minmax_element(voxels.key.begin(), voxels.key.end(),
                            [=](const auto& a, const auto& b) { return a[axis] < b[axis]; });
    const size_t lowest = (*first)[axis];
    std::vector<uint32_t> layers((*last)[axis] - lowest + 1);
    for (const auto& key : voxels.key) layers[key[axis] - lowest]++;
    constexpr double kOrigin = 0.5 * (1U << OcTreeCube::kMaxDepth);
    const auto middleOf = [&](size_t layer) {  // as OccupiedVoxels::centre, bit for bit
      const auto key = static_cast<double>(lowest + layer);
      return static_cast<float>(voxels.resolution * (key - kOrigin + 0.5));
    };
    size_t low = 0, high = layers.size() - 1;
    for (size_t outside = layers[low]; outside <= stray;) outside += layers[++low];
    for (size_t outside = layers[high]; outside <= stray;) outside += layers[--high];
    box.min()[axis] = middleOf(low);
    box.max()[axis] = middleOf(high);
  }
  return box;
}

/** How well the walls of two maps, by the headings of their normals, lie along each other as one
 * map turns. */
class WallDirections {
 public:
  WallDirections(const Normals& a, const Normals& b, const Eigen::Isometry3d& T_a_b) {
    const Histogram of_a = histogram(a, Eigen::Matrix3d::Identity());
    const Histogram of_b = histogram(b, T_a_b.linear());
    for (int turn = 0; turn < kBins; turn++)
      for (int i = 0; i < kBins; i++)
        fit_[static_cast<size_t>(turn)] += of_a[wrapped(i + turn)] * of_b[static_cast<size_t>(i)];
    double mean = 0;
    for (const double f : fit_) {
      mean += f / kBins;
      best_ = std::max(best_, f);
    }
    least_ = mean + kShare * (best_ - mean);
  }

  /** Whether turning b by an angle, or by up to half a step more or less, may be right, rad. */
  bool arePlausible(double yaw, double step) const {
    const int middle = static_cast<int>(std::lround(yaw / kBin));
    const int half = static_cast<int>(std::ceil(0.5 * step / kBin));
    for (int i = middle - half; i <= middle + half; i++)
      if (fit_[wrapped(i)] >= least_) return true;
    return false;
  }

 private:
  static constexpr int kBins = 180;  ///< of half a turn: normals have no sign
  static constexpr double kBin = M_PI / kBins;
  static constexpr double kShare = 0.25;  ///< of what the best turn has more than the mean
  using Histogram = std::array<double, kBins>;

  static size_t wrapped(int bin) { return static_cast<size_t>((bin % kBins + kBins) % kBins); }

  static Histogram histogram(const Normals& normals, const Eigen::Matrix3d& R) {
    constexpr int kSpread = 2;  // degrees: normals of walls scatter
    Histogram h{};
    for (const Eigen::Vector3f& normal : normals) {
      const Eigen::Vector3d n = R * normal.cast<double>();
      const double upright = n.head<2>().norm();  // 1 on walls, 0 on floors and without a normal
      if (upright < 0.5) continue;
      const int bin = static_cast<int>(std::floor(std::atan2(n.y(), n.x()) / kBin));
      for (int d = -kSpread; d <= kSpread; d++) h[wrapped(bin + d)] += upright;
    }
    return h;
  }

  Histogram fit_{};
  double best_ = 0, least_ = 0;
};

/** Some of the points, in their order. */
Points someOf(const Points& points, size_t enough) {
  Points some;
  const size_t stride = strideFor(points.size(), enough);
  for (size_t i = 0; i < points.size(); i += stride) some.push_back(points[i]);
  return some;
}

/** A search of the poses around a guess, see searchAround(). */
class PoseSearch {
 public:
  PoseSearch(const MapVoxels& a, const Surfaces& surfaces_a, const SurfaceVoxels& b,
             const Eigen::Isometry3d& T_a_b, const SearchParams& params)
      : a_(a), params_(params) {
    if (params.isEverywhere()) walls_.emplace(surfaces_a.normal, b.surfaces.normal, T_a_b);
    heights_ = {-params.height, params.height};
    const Eigen::AlignedBox3d most = boxOfMost(b.voxels);
    for (const auto& p : b.voxels.centre)
      if (most.contains(p.cast<double>())) points_.push_back(p);
    box_a_ = boxOfMost(a.voxels);
    const Eigen::Vector3d middle = T_a_b * meanOf(points_);
    for (const auto& p : points_)
      radius_ = std::max(radius_, (T_a_b * p.cast<double>() - middle).head<2>().norm());
    region_ = region(T_a_b);
    finest_ = layoutFor(b.voxels.resolution);
    radius_ = std::max(radius_, finest_.cell);
    lattice_ = {T_a_b, middle, finest_.cell, finest_.cell / radius_};
  }

  std::vector<Hypothesis> run() {
    std::vector<ScoreGrid> grids = {ScoreGrid(a_, region_, finest_)};
    constexpr double kLittleWork = 5e7, kMostWork = 2e9;
    // By few points, more if it is worth it, at the finest level whose places are few enough, then
    // down around the best.
    Points few = someOf(points_, ScoreGrid::kMostSummed);
    if (work(0, few) > kLittleWork) {
      alignFloors();
      while (few.size() < points_.size() && 2 * work(0, few) <= kMostWork)
        few = someOf(points_, 2 * few.size());
    }
    unsigned level = 0;
    while (work(level, few) > kMostWork && level < kMostLevels) {
      grids.push_back(grids.back().coarser());
      level++;
    }
    const size_t kept = level > 0 ? kKept : std::min<size_t>(kKept, 32 * params_.hypotheses);
    std::vector<Place> places = exhaustive(grids[level], level, few, kept, same(level));
    while (level-- > 0) places = refine(grids[level], level, few, places);
    return hypotheses(rescored(grids[0], places));
  }

 private:
  std::vector<Hypothesis> hypotheses(const std::vector<Place>& places) const {
    std::vector<Hypothesis> best;
    for (const Place& p : places) best.push_back({lattice_.at(p), static_cast<double>(p.score)});
    return best;
  }

  static constexpr unsigned kMostLevels = 6;
  static constexpr size_t kKept = 2048;  ///< places that a level hands to the next finer one

  /** The part of map A that tells poses apart: where B's voxels can come to lie, and free space
   * not far from all obstacles. */
  Eigen::AlignedBox3d region(const Eigen::Isometry3d& T) const {
    constexpr double kBeside = 5;
    const double beside = std::min(params_.translation + params_.height, kBeside);
    Eigen::AlignedBox3d near_a = box_a_;
    near_a.extend(box_a_.min() - Eigen::Vector3d::Constant(beside));
    near_a.extend(box_a_.max() + Eigen::Vector3d::Constant(beside));
    // The window of a yaw reaches three translations; turned, B stays within its radius.
    Eigen::AlignedBox3d box_b = boxOf(points_, T);
    const double reach = 3 * params_.translation + (params_.yaw > 0 ? radius_ : 0);
    const Eigen::Vector3d extra(reach, reach, 2 * params_.height);
    box_b.extend(box_b.min() - extra);
    box_b.extend(box_b.max() + extra);
    const Eigen::AlignedBox3d common = near_a.intersection(box_b);
    return common.isEmpty() ? Eigen::AlignedBox3d(box_a_.min(), box_a_.min()) : common;
  }

  /** The cell's side: as asked for, at least two voxels, and so large that the grid stays small
   * however far apart the pieces of the maps lie; rounded up to a cube of A's octree. */
  ScoreGrid::Layout layoutFor(double resolution_b) const {
    constexpr double kMostCells = 64e6;
    const double least = std::max({params_.cell, 2 * a_.voxels.resolution, 2 * resolution_b,
                                   std::cbrt(region_.volume() / kMostCells)});
    ScoreGrid::Layout layout{a_.voxels.resolution, 0};
    while (layout.cell < least * (1 - 1e-9) && layout.level + 1 < OcTreeCube::kMaxDepth) {
      layout.cell *= 2;
      layout.level++;
    }
    return layout;
  }

  /** Moves the lattice to the height at which most obstacles find one at their own: half a wide
   * cell off, floors, which are most of a map, would miss each other at all of its places. */
  void alignFloors() {
    const double step = std::max(a_.voxels.resolution, 0.25 * lattice_.cell);
    const auto layerOf = [step](double z) { return static_cast<int>(std::floor(z / step)); };
    const Eigen::AlignedBox3d box_b = boxOf(points_, lattice_.T_a_b);
    const int low_a = layerOf(box_a_.min().z()), low_b = layerOf(box_b.min().z());
    std::vector<double> layers_a(static_cast<size_t>(layerOf(box_a_.max().z()) - low_a + 1));
    std::vector<double> layers_b(static_cast<size_t>(layerOf(box_b.max().z()) - low_b + 1));
    for (const auto& p : a_.voxels.centre) {
      const int layer = layerOf(p.z()) - low_a;
      if (layer >= 0 && layer < static_cast<int>(layers_a.size()))
        layers_a[static_cast<size_t>(layer)]++;
    }
    for (const auto& p : points_)
      layers_b[static_cast<size_t>(layerOf((lattice_.T_a_b * p.cast<double>()).z()) - low_b)]++;
    const int most = static_cast<int>(std::min(params_.height / step, 1e6));
    const int first = std::max(-most, low_a - low_b - static_cast<int>(layers_b.size()));
    std::vector<double> fit;
    for (int s = first; s <= std::min(most, low_a - low_b + static_cast<int>(layers_a.size()));
         s++) {
      fit.push_back(0);
      for (size_t k = 0; k < layers_b.size(); k++) {
        const int layer = static_cast<int>(k) + low_b + s - low_a;
        if (layer >= 0 && layer < static_cast<int>(layers_a.size()))
          fit.back() += layers_b[k] * layers_a[static_cast<size_t>(layer)];
      }
    }
    const auto best = std::max_element(fit.begin(), fit.end());
    if (best == fit.end() || *best == 0) return;  // they share no height that may be tried
    constexpr double kShare = 0.6;  // of the best: floors on other storeys' floors, not on ceilings
    const auto isGood = [&](double f) { return f >= kShare * *best; };
    const auto lowest = std::find_if(fit.begin(), best, isGood);
    const auto highest = std::find_if(fit.rbegin(), fit.rend(), isGood);
    heights_ = {step * static_cast<double>(lowest - best),
                step * static_cast<double>(highest.base() - 1 - best)};
    const auto shift = static_cast<double>(first + (best - fit.begin()));
    const Eigen::Vector3d up(0, 0, shift * step);
    lattice_.T_a_b.pretranslate(up);
    lattice_.middle += up;
  }

  /** The yaws to try: around a guess all, else those that lay walls along walls. */
  std::vector<int> yawsAt(const Lattice& lattice) const {
    const int most = static_cast<int>(std::ceil(std::min(params_.yaw, M_PI) / lattice.yaw_step));
    std::vector<int> yaws;
    for (int yaw = -most; yaw <= most; yaw++)
      if (!walls_ || walls_->arePlausible(yaw * lattice.yaw_step, lattice.yaw_step))
        yaws.push_back(yaw);
    return yaws;
  }

  /** A guess that is wrong in yaw turned the map about the origin of B's frame as likely as about
   * its middle, which then lies elsewhere: the window of a yaw covers both, as far as the maps can
   * overlap. */
  Window windowOf(const Lattice& lattice, int yaw, const Points& points) const {
    const Eigen::Vector3d lever = lattice.middle - lattice.T_a_b.translation();
    const Eigen::Vector3d swing =
        Eigen::AngleAxisd(yaw * lattice.yaw_step, Eigen::Vector3d::UnitZ()) * lever - lever;
    const Eigen::AlignedBox3d box_b = boxOf(points, lattice.turned(yaw));
    Window w;
    for (int axis = 0; axis < 3; axis++) {
      const double cell = lattice.cell;
      const double far = std::ceil(params_.translation / cell);
      const double shift = std::clamp(std::round(swing[axis] / cell), -2 * far, 2 * far);
      const double nearest =
          axis == 2 ? std::floor(heights_[0] / cell) : std::min(0.0, shift) - far;
      const double farthest =
          axis == 2 ? std::ceil(heights_[1] / cell) : std::max(0.0, shift) + far;
      const double low =
          std::max(nearest, std::floor((box_a_.min()[axis] - box_b.max()[axis]) / cell));
      const double high =
          std::min(farthest, std::ceil((box_a_.max()[axis] - box_b.min()[axis]) / cell));
      w.low[axis] = static_cast<int>(low);
      w.size[axis] = static_cast<int>(std::max(0.0, high - low + 1));
    }
    return w;
  }

  /** Values to add up at a level. */
  double work(unsigned level, const Points& points) const {
    const Lattice lattice = lattice_.level(level);
    const std::vector<int> yaws = yawsAt(lattice);
    constexpr size_t kSample = 16;  // of the windows
    const size_t stride = (yaws.size() + kSample - 1) / kSample;
    double sum = 0, n = 0;
    for (size_t i = 0; i < yaws.size(); i += stride, n++)
      sum += static_cast<double>(windowOf(lattice, yaws[i], points).cells());
    return sum / std::max(n, 1.0) * static_cast<double>(yaws.size() * points.size());
  }

  int stepsOfATurn(unsigned level) const {
    return static_cast<int>(std::lround(2 * M_PI / lattice_.level(level).yaw_step));
  }
  Near same(unsigned level) const { return {1, 1, stepsOfATurn(level)}; }
  /** Final places differ by more. */
  Near another() const {
    constexpr double kNearYaw = 10 * M_PI / 180;
    return {3, static_cast<int>(kNearYaw / lattice_.yaw_step), stepsOfATurn(0)};
  }

  std::vector<Place> exhaustive(const ScoreGrid& grid, unsigned level, const Points& points,
                                size_t count, const Near& near) const {
    constexpr size_t kOfAYaw = 128;
    const Lattice lattice = lattice_.level(level);
    const std::vector<int> yaws = yawsAt(lattice);
    std::vector<std::vector<Place>> of_yaw(yaws.size());
    forEachIndex(of_yaw.size(), 1, [&](size_t i) {
      const Window window = windowOf(lattice, yaws[i], points);
      const auto scene = cellsOf(grid, points, lattice.turned(yaws[i]));
      of_yaw[i] =
          mostDistinct(scoreWindow(grid, scene, yaws[i], window), std::min(count, kOfAYaw), near);
    });
    return mostDistinct(concatenated(of_yaw), count, near);
  }

  /** From the places of the next coarser level. */
  std::vector<Place> refine(const ScoreGrid& grid, unsigned level, const Points& points,
                            const std::vector<Place>& coarse) const {
    const Lattice lattice = lattice_.level(level);
    std::vector<std::vector<Place>> best(coarse.size());
    forEachIndex(coarse.size(), 1, [&](size_t i) {
      const Place& c = coarse[i];
      const Window window{{2 * c.x - 2, 2 * c.y - 2, 2 * c.z - 2}, {5, 5, 5}};
      std::vector<Place> around;
      for (int yaw = 2 * c.yaw - 1; yaw <= 2 * c.yaw + 1; yaw++) {
        const auto scene = cellsOf(grid, points, lattice.turned(yaw));
        const auto places = scoreWindow(grid, scene, yaw, window);
        around.insert(around.end(), places.begin(), places.end());
      }
      best[i] = mostDistinct(std::move(around), 1, same(level));
    });
    return mostDistinct(concatenated(best), kKept, same(level));
  }

  /** By all points, at the finest level. */
  std::vector<Place> rescored(const ScoreGrid& grid, const std::vector<Place>& places) const {
    std::map<int, std::vector<Place>> by_yaw;
    for (const Place& p : places) by_yaw[p.yaw].push_back(p);
    const std::vector<std::pair<int, std::vector<Place>>> yaws(by_yaw.begin(), by_yaw.end());
    std::vector<std::vector<Place>> exactly(yaws.size());
    forEachIndex(yaws.size(), 1, [&](size_t i) {
      const auto& [yaw, of_yaw] = yaws[i];
      const auto scene = cellsOf(grid, points_, lattice_.turned(yaw));
      for (const Place& p : of_yaw)
        exactly[i].push_back(scoreWindow(grid, scene, yaw, {{p.x, p.y, p.z}, {1, 1, 1}}).front());
    });
    return mostDistinct(concatenated(exactly), params_.hypotheses, another());
  }

  static std::vector<Place> concatenated(const std::vector<std::vector<Place>>& lists) {
    std::vector<Place> all;
    for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
  }

  const MapVoxels& a_;
  Points points_;  // of the scene
  const SearchParams& params_;
  std::optional<WallDirections> walls_;
  Eigen::AlignedBox3d box_a_, region_;
  std::array<double, 2> heights_{};  // lowest and highest shift to try, m
  double radius_ = 0;                // of B about its middle, across the vertical, m
  ScoreGrid::Layout finest_{};
  Lattice lattice_{};
};

}  // namespace

SearchParams everywhere(SearchParams params) {
  constexpr unsigned kLeastHypotheses = 256;
  params.translation = params.height = params.yaw = std::numeric_limits<double>::infinity();
  params.hypotheses = std::max(params.hypotheses, kLeastHypotheses);
  return params;
}

std::vector<Hypothesis> searchAround(const MapVoxels& a, const Surfaces& surfaces_a,
                                     const SurfaceVoxels& b, const Eigen::Isometry3d& T_a_b,
                                     const SearchParams& params) {
  if (a.voxels.size() == 0 || b.voxels.size() == 0 || params.translation <= 0 ||
      params.hypotheses == 0)
    return {};
  return PoseSearch(a, surfaces_a, b, T_a_b, params).run();
}

std::vector<Eigen::Vector3d> dominantDirections(const Surfaces& surfaces, size_t most) {
  constexpr size_t kEnough = 1500;
  constexpr double kLeast = 0.02;  // of all
  const double alike = std::cos(8 * M_PI / 180), apart = std::cos(20 * M_PI / 180);
  std::vector<Eigen::Vector3d> normals;  // times the square root of their weight
  const size_t stride = strideFor(surfaces.normal.size(), kEnough);
  for (size_t i = 0; i < surfaces.normal.size(); i += stride)
    if (!surfaces.normal[i].isZero())
      normals.emplace_back(std::sqrt(surfaces.weight[i]) * surfaces.normal[i].cast<double>());
  double all = 0;
  for (const auto& n : normals) all += n.squaredNorm();

  const auto face = [](const Eigen::Vector3d& n, const Eigen::Vector3d& direction, double cosine) {
    return std::abs(n.dot(direction)) > cosine * n.norm();
  };
  std::vector<Eigen::Vector3d> directions;
  while (directions.size() < most) {
    double of_best = kLeast * all;
    Eigen::Vector3d best = Eigen::Vector3d::Zero();
    for (const auto& candidate : normals) {
      double sum = 0;
      for (const auto& n : normals)
        if (face(n, candidate.normalized(), alike)) sum += n.squaredNorm();
      if (sum > of_best) {
        of_best = sum;
        best = candidate.normalized();
      }
    }
    if (best.isZero()) break;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const auto& n : normals)
      if (face(n, best, alike)) scatter += n * n.transpose();
    directions.emplace_back(
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(2));
    normals.erase(std::remove_if(normals.begin(), normals.end(),
                                 [&](const auto& n) { return face(n, directions.back(), apart); }),
                  normals.end());
  }
  return directions;
}

std::vector<Hypothesis> searchAllRotations(const MapVoxels& a, const Surfaces& surfaces_a,
                                           const SurfaceVoxels& b, const SearchParams& params) {
  constexpr size_t kDirections = 4;
  const double upright = std::cos(3 * M_PI / 180);  // matching takes up as much
  const auto facing_a = dominantDirections(surfaces_a, 1);
  const auto facing_b = dominantDirections(b.surfaces, kDirections);
  if (facing_a.empty()) return {};

  // A's dominant direction becomes the axis that searchAround() turns about.
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  Eigen::Isometry3d T_turned_a = Eigen::Isometry3d::Identity();
  std::unique_ptr<octomap::OcTree> turned_map;
  MapVoxels turned;
  Surfaces turned_surfaces;
  const bool is_upright = std::abs(facing_a[0].dot(z)) > upright;
  if (!is_upright) {
    T_turned_a.linear() = Eigen::Quaterniond::FromTwoVectors(facing_a[0], z).toRotationMatrix();
    turned_map = transformOcTree(*a.map, T_turned_a, a.map->getResolution());
    turned = MapVoxels(*turned_map);
    turned_surfaces = surfaces_a;
    for (auto& n : turned_surfaces.normal) n = T_turned_a.linear().cast<float>() * n;
  }

  std::vector<Hypothesis> all;
  for (const auto& direction : facing_b)
    for (const double sign : {1.0, -1.0}) {
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.linear() =
          Eigen::Quaterniond::FromTwoVectors(sign * direction, T_turned_a.linear() * facing_a[0])
              .toRotationMatrix();
      auto found = is_upright ? searchAround(a, surfaces_a, b, T, params)
                              : searchAround(turned, turned_surfaces, b, T, params);
      for (Hypothesis& h : found) h.T_a_b = T_turned_a.inverse() * h.T_a_b;
      all.insert(all.end(), found.begin(), found.end());
    }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& g, const auto& h) { return g.score > h.score; });
  if (all.size() > params.hypotheses) all.resize(params.hypotheses);
  return all;
}

}  // namespace mrpt::fusion
