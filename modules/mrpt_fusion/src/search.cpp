// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/search.h>
#include <mrpt/maps/octree_build.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <tuple>
#include <utility>

#include "parallel.h"

namespace mrpt::fusion {
namespace {

using Cell = std::array<int, 3>;

/** A coarse copy of a map, of the octree's own cubes: whether an obstacle at a cell speaks for a
 * pose or against it. A cell beside an occupied one says nothing: quantisation puts many points of
 * a wall there. Dense, x fastest; beyond it all is unknown. */
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
            const Layout& layout)
      : layout_(layout) {
    const Cell low = layout.cellOf(region.min()), high = layout.cellOf(region.max());
    for (unsigned axis = 0; axis < 3; axis++) {
      low_[axis] = low[axis] - 1;
      size_[axis] = high[axis] + 2 - low_[axis];
    }
    values_.assign(cells(), kUnknown);
    if (map.getRoot()) markKnown(map, *map.getRoot(), {});
    for (const auto& key : a.key) mark(layout.cellOf(key), 1, kOccupied);
    clearBesideOccupied();
  }

  /** The same with cells twice as wide: each holds the highest value in it, so that no obstacle
   * that confirms a pose is lost. */
  ScoreGrid coarser() const {
    ScoreGrid c(*this);
    c.layout_ = {2 * layout_.cell, layout_.level + 1};
    for (unsigned axis = 0; axis < 3; axis++) {
      c.low_[axis] = low_[axis] >> 1;
      c.size_[axis] = ((low_[axis] + size_[axis] - 1) >> 1) + 1 - c.low_[axis];
    }
    c.values_.assign(c.cells(), kFree);  // the outermost cells are unknown, and make theirs so
    for (int z = 0; z < size_[2]; z++)
      for (int y = 0; y < size_[1]; y++)
        for (int x = 0; x < size_[0]; x++) {
          int8_t& v =
              c.values_[c.index(((low_[0] + x) >> 1) - c.low_[0], ((low_[1] + y) >> 1) - c.low_[1],
                                ((low_[2] + z) >> 1) - c.low_[2])];
          v = std::max(v, values_[index(x, y, z)]);
        }
    return c;
  }

  Cell cellOf(const Eigen::Vector3d& p) const { return layout_.cellOf(p); }

  /** Adds the values of \a length cells along x, from one on. */
  void addRun(int x, int y, int z, int length, int8_t* sums) const {
    x -= low_[0];
    y -= low_[1];
    z -= low_[2];
    if (y < 0 || y >= size_[1] || z < 0 || z >= size_[2]) return;
    const int first = std::max(0, -x), end = std::min(length, size_[0] - x);
    if (first >= end) return;
    const int8_t* values = &values_[index(x + first, y, z)];
    sums += first;
    for (int k = 0; k < end - first; k++) sums[k] = static_cast<int8_t>(sums[k] + values[k]);
  }

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

  size_t cells() const {
    return static_cast<size_t>(size[0]) * static_cast<size_t>(size[1]) *
           static_cast<size_t>(size[2]);
  }
};

/** A pose of a lattice: yaw in steps, translation in cells. */
struct Place {
  int32_t score;
  int yaw, x, y, z;

  int64_t farness() const {
    const auto square = [](int64_t v) { return v * v; };
    return square(yaw) + square(x) + square(y) + square(z);
  }
  bool isBetterThan(const Place& o) const {  // near the guess first
    return std::make_tuple(-score, farness(), yaw, x, y, z) <
           std::make_tuple(-o.score, o.farness(), o.yaw, o.x, o.y, o.z);
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

/** The places of one yaw. */
std::vector<Place> scoreWindow(const ScoreGrid& grid, const Lattice& lattice, int yaw,
                               const Points& points, const Window& window) {
  const auto& [low, size] = window;
  std::vector<int32_t> sums(window.cells());
  // As many points at a time as cannot overflow a byte: sixteen places to an instruction.
  constexpr size_t kAtATime = 127 / kConflictWeight;
  std::vector<int8_t> some(sums.size());
  const Eigen::Isometry3d T = lattice.turned(yaw);
  for (size_t first = 0; first < points.size(); first += kAtATime) {
    std::fill(some.begin(), some.end(), 0);
    for (size_t i = first; i < std::min(first + kAtATime, points.size()); i++) {
      const Cell c = grid.cellOf(T * points[i].cast<double>());
      int8_t* row = some.data();
      for (int z = 0; z < size[2]; z++)
        for (int y = 0; y < size[1]; y++, row += size[0])
          grid.addRun(c[0] + low[0], c[1] + low[1] + y, c[2] + low[2] + z, size[0], row);
    }
    for (size_t k = 0; k < sums.size(); k++) sums[k] += some[k];
  }

  std::vector<Place> places;
  places.reserve(sums.size());
  size_t i = 0;
  for (int z = 0; z < size[2]; z++)
    for (int y = 0; y < size[1]; y++)
      for (int x = 0; x < size[0]; x++)
        places.push_back({sums[i++], yaw, low[0] + x, low[1] + y, low[2] + z});
  return places;
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

Eigen::Vector3d meanOf(const Points& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p.cast<double>();
  return sum / static_cast<double>(std::max<size_t>(1, points.size()));
}

Eigen::AlignedBox3d boxOf(const Points& points, const Eigen::Isometry3d& T) {
  Eigen::AlignedBox3d box;
  for (const auto& p : points) box.extend(T * p.cast<double>());
  return box;
}

/** The box without the outermost points, one of 200 along each axis and to each side: stray returns
 * lie far from a map, and tell nothing of where another can lie. */
Eigen::AlignedBox3d boxOfMost(Points points) {
  Eigen::AlignedBox3d box;
  const size_t stray = points.size() / 200;
  for (const auto& p : points) box.extend(p.cast<double>());
  if (points.empty() || stray == 0) return box;
  for (int axis = 0; axis < 3; axis++) {
    const auto nth = [&](size_t n) {
      const auto at = points.begin() + static_cast<std::ptrdiff_t>(n);
      std::nth_element(points.begin(), at, points.end(),
                       [axis](const auto& p, const auto& q) { return p[axis] < q[axis]; });
      return static_cast<double>((*at)[axis]);
    };
    box.min()[axis] = nth(stray);
    box.max()[axis] = nth(points.size() - 1 - stray);
  }
  return box;
}

/** Some of the points, in their order. */
Points someOf(const Points& points, size_t enough) {
  Points some;
  const size_t stride = (points.size() + enough - 1) / enough;
  for (size_t i = 0; i < points.size(); i += stride) some.push_back(points[i]);
  return some;
}

/** A search of the poses around a guess, see searchAround(). */
class PoseSearch {
 public:
  PoseSearch(const octomap::OcTree& map_a, const OccupiedVoxels& a, const OccupiedVoxels& b,
             const Eigen::Isometry3d& T_a_b, const SearchParams& params)
      : map_a_(map_a), a_(a), params_(params) {
    const Eigen::AlignedBox3d most = boxOfMost(b.centre);
    for (const auto& p : b.centre)
      if (most.contains(p.cast<double>())) points_.push_back(p);
    box_a_ = boxOfMost(a.centre);
    const Eigen::Vector3d middle = T_a_b * meanOf(points_);
    for (const auto& p : points_)
      radius_ = std::max(radius_, (T_a_b * p.cast<double>() - middle).head<2>().norm());
    region_ = region(middle, T_a_b);
    finest_ = layoutFor(b.resolution);
    radius_ = std::max(radius_, finest_.cell);
    lattice_ = {T_a_b, middle, finest_.cell, finest_.cell / radius_};
  }

  std::vector<Hypothesis> run() const {
    // Exhaustively at the finest level whose places are few enough, then down around the best.
    constexpr double kMostWork = 2e9;
    std::vector<ScoreGrid> grids = {ScoreGrid(map_a_, a_, region_, finest_)};
    unsigned level = 0;
    while (work(level) > kMostWork && level < kMostLevels) {
      grids.push_back(grids.back().coarser());
      level++;
    }
    if (level == 0) return hypotheses(exhaustive(grids[0], 0, params_.hypotheses));
    std::vector<Place> places = exhaustive(grids[level], level, kKept);
    while (level-- > 0)
      places = refine(grids[level], level, places, level == 0 ? kRescored : kKept);
    return hypotheses(rescored(grids[0], places));
  }

 private:
  std::vector<Hypothesis> hypotheses(const std::vector<Place>& places) const {
    std::vector<Hypothesis> best;
    for (const Place& p : places) best.push_back({lattice_.at(p), static_cast<double>(p.score)});
    return best;
  }

  static constexpr unsigned kMostLevels = 6;
  /** Places that a level hands to the next finer one, and that are scored by all points. */
  static constexpr size_t kKept = 2048, kRescored = 256;

  /** The part of map A that tells poses apart: where B's voxels can come to lie, and free space
   * not far from all obstacles. */
  Eigen::AlignedBox3d region(const Eigen::Vector3d& middle, const Eigen::Isometry3d& T) const {
    constexpr double kBeside = 5;
    const double beside = std::min(params_.translation + params_.height, kBeside);
    Eigen::AlignedBox3d near_a = box_a_;
    near_a.extend(box_a_.min() - Eigen::Vector3d::Constant(beside));
    near_a.extend(box_a_.max() + Eigen::Vector3d::Constant(beside));
    // The window of a yaw reaches three translations; turned, B stays within its radius.
    Eigen::AlignedBox3d box_b = boxOf(points_, T);
    const double reach = 3 * params_.translation + (params_.yaw > 0 ? radius_ : 0);
    const Eigen::Vector3d extra(reach, reach, 2 * params_.height);
    box_b.extend(middle - extra);
    box_b.extend(middle + extra);
    box_b.extend(box_b.min() - extra);
    box_b.extend(box_b.max() + extra);
    const Eigen::AlignedBox3d common = near_a.intersection(box_b);
    return common.isEmpty() ? Eigen::AlignedBox3d(box_a_.min(), box_a_.min()) : common;
  }

  /** The cell's side: as asked for, at least two voxels, and so large that the grid stays small
   * however far apart the pieces of the maps lie; rounded up to a cube of A's octree. */
  ScoreGrid::Layout layoutFor(double resolution_b) const {
    constexpr double kMostCells = 64e6;
    const double least = std::max({params_.cell, 2 * a_.resolution, 2 * resolution_b,
                                   std::cbrt(region_.volume() / kMostCells)});
    ScoreGrid::Layout layout{a_.resolution, 0};
    while (layout.cell < least * (1 - 1e-9)) {
      layout.cell *= 2;
      layout.level++;
    }
    return layout;
  }

  /** The scene's points to try at a level: few will do to tell what is worth a closer look. */
  Points fewPoints() const {
    constexpr size_t kEnough = 250;
    return someOf(points_, kEnough);
  }

  int yawsAt(const Lattice& lattice) const {
    const double most = std::min(params_.yaw, M_PI);
    return static_cast<int>(std::ceil(most / lattice.yaw_step));
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
      const double far = std::ceil((axis == 2 ? params_.height : params_.translation) / cell);
      const double shift =
          axis == 2 ? 0 : std::clamp(std::round(swing[axis] / cell), -2 * far, 2 * far);
      const double low = std::max(std::min(0.0, shift) - far,
                                  std::floor((box_a_.min()[axis] - box_b.max()[axis]) / cell));
      const double high = std::min(std::max(0.0, shift) + far,
                                   std::ceil((box_a_.max()[axis] - box_b.min()[axis]) / cell));
      w.low[axis] = static_cast<int>(low);
      w.size[axis] = static_cast<int>(std::max(0.0, high - low + 1));
    }
    return w;
  }

  /** Values to add up at a level. */
  double work(unsigned level) const {
    const Lattice lattice = lattice_.level(level);
    const Points points = level == 0 ? points_ : fewPoints();
    const int yaws = yawsAt(lattice);
    constexpr int kSample = 8;  // of the windows
    double sum = 0;
    int n = 0;
    for (int yaw = -yaws; yaw <= yaws; yaw += std::max(1, yaws / kSample), n++)
      sum += static_cast<double>(windowOf(lattice, yaw, points).cells());
    return sum / n * (2.0 * yaws + 1) * static_cast<double>(points.size());
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

  std::vector<Place> exhaustive(const ScoreGrid& grid, unsigned level, size_t count) const {
    constexpr size_t kOfAYaw = 64;
    const Lattice lattice = lattice_.level(level);
    const Points points = level == 0 ? points_ : fewPoints();
    const Near near = level == 0 ? another() : same(level);
    const int yaws = yawsAt(lattice);
    std::vector<std::vector<Place>> of_yaw(static_cast<size_t>(2 * yaws + 1));
    forEachIndex(of_yaw.size(), 1, [&](size_t i) {
      const int yaw = static_cast<int>(i) - yaws;
      const Window window = windowOf(lattice, yaw, points);
      of_yaw[i] = mostDistinct(scoreWindow(grid, lattice, yaw, points, window),
                               std::min(count, kOfAYaw), near);
    });
    return mostDistinct(concatenated(of_yaw), count, near);
  }

  /** From the places of the next coarser level. */
  std::vector<Place> refine(const ScoreGrid& grid, unsigned level, const std::vector<Place>& coarse,
                            size_t count) const {
    const Lattice lattice = lattice_.level(level);
    const Points points = fewPoints();
    std::vector<std::vector<Place>> best(coarse.size());
    forEachIndex(coarse.size(), 1, [&](size_t i) {
      const Place& c = coarse[i];
      const Window window{{2 * c.x - 2, 2 * c.y - 2, 2 * c.z - 2}, {5, 5, 5}};
      std::vector<Place> around;
      for (int yaw = 2 * c.yaw - 1; yaw <= 2 * c.yaw + 1; yaw++) {
        const auto places = scoreWindow(grid, lattice, yaw, points, window);
        around.insert(around.end(), places.begin(), places.end());
      }
      best[i] = mostDistinct(std::move(around), 1, same(level));
    });
    return mostDistinct(concatenated(best), count, same(level));
  }

  /** By all points, at the finest level. */
  std::vector<Place> rescored(const ScoreGrid& grid, const std::vector<Place>& places) const {
    std::vector<std::vector<Place>> exactly(places.size());
    forEachIndex(places.size(), 1, [&](size_t i) {
      const Place& p = places[i];
      exactly[i] = scoreWindow(grid, lattice_, p.yaw, points_, {{p.x, p.y, p.z}, {1, 1, 1}});
    });
    return mostDistinct(concatenated(exactly), params_.hypotheses, another());
  }

  static std::vector<Place> concatenated(const std::vector<std::vector<Place>>& lists) {
    std::vector<Place> all;
    for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
  }

  const octomap::OcTree& map_a_;
  const OccupiedVoxels& a_;
  Points points_;  // of the scene
  const SearchParams& params_;
  Eigen::AlignedBox3d box_a_, region_;
  double radius_ = 0;  // of B about its middle, across the vertical, m
  ScoreGrid::Layout finest_{};
  Lattice lattice_{};
};

}  // namespace

SearchParams everywhere(SearchParams params) {
  constexpr unsigned kLeastHypotheses = 16;
  params.translation = params.height = params.yaw = std::numeric_limits<double>::infinity();
  params.hypotheses = std::max(params.hypotheses, kLeastHypotheses);
  return params;
}

std::vector<Hypothesis> searchAround(const octomap::OcTree& map_a, const OccupiedVoxels& a,
                                     const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                                     const SearchParams& params) {
  if (a.size() == 0 || b.size() == 0 || params.translation <= 0 || params.hypotheses == 0)
    return {};
  return PoseSearch(map_a, a, b, T_a_b, params).run();
}

}  // namespace mrpt::fusion
