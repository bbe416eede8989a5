// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Searches a lattice of poses, from coarse to fine. */
#include "fusion_core/search/pose_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "fusion_base/parallel.h"
#include "fusion_base/whole_number.h"
#include "fusion_core/search/floor_heights.h"
#include "fusion_core/search/pose_lattice.h"
#include "fusion_core/search/score_grid.h"
#include "fusion_core/search/wall_directions.h"
#include "fusion_octree/build.h"

namespace mrpt::fusion {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/** Returns the score of a pose. Conflicts reduce the weight of confirmed obstacles: if rooms or
 * pillars repeat, a wrong pose with a larger overlap would otherwise win. With the default weight,
 * a conflict for each 10 confirmed obstacles leaves 25 %. */
float scoreOf(uint32_t confirmed, uint32_t conflicting, float conflict_weight) {
  if (confirmed == 0) return 0;
  const auto n = static_cast<float>(confirmed);
  const float share = n / (n + conflict_weight * static_cast<float>(conflicting));
  return n * share * share;
}

/** Returns the cells of points in the grid. */
std::vector<Cell> cellsOf(const ScoreGrid& grid, const Points& points, const Eigen::Isometry3d& T) {
  std::vector<Cell> cells(points.size());
  for (size_t i = 0; i < points.size(); i++) cells[i] = grid.cellOf(T * points[i].cast<double>());
  return cells;
}

/** Scores the places of one yaw. Returns the best height for each x and y: all other heights are
 * near this place. \a b holds the cells of B's points, turned by the yaw. */
std::vector<Place> scoreWindow(const ScoreGrid& grid, const std::vector<Cell>& b, int yaw,
                               const Window& window, double weight_of_conflicts) {
  const auto conflict_weight = static_cast<float>(weight_of_conflicts);
  const auto& [low, size] = window;
  struct Counts {
    uint32_t occupied = 0, free = 0;
  };
  const int row_length = ScoreGrid::padded(size[0]);
  const size_t rows = static_cast<size_t>(size[1]) * static_cast<size_t>(size[2]);
  std::vector<Counts> counts(rows * static_cast<size_t>(row_length));
  std::vector<uint16_t> some(counts.size());
  for (size_t first = 0; first < b.size(); first += ScoreGrid::kMostSummed) {
    std::fill(some.begin(), some.end(), 0);
    for (size_t i = first; i < std::min(first + ScoreGrid::kMostSummed, b.size()); i++) {
      const auto& [x, y, z] = b[i];
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
        const Place place{scoreOf(row[x].occupied, row[x].free, conflict_weight), yaw, low[0] + x,
                          low[1] + y, low[2] + z};
        if (place.isBetterThan(*column)) *column = place;
      }
  }
  return best;
}

Eigen::AlignedBox3d boxOf(const Points& points, const Eigen::Isometry3d& T) {
  Eigen::AlignedBox3d box;
  for (const auto& p : points) box.extend(T * p.cast<double>());
  return box;
}

/** Returns the bounding box without the outermost 0.5 % of the voxels at each end of each axis.
 * Stray returns lie far from a map and must not widen the search. */
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
    const auto middleOf = [&](size_t layer) {  // equal to OccupiedVoxels::centre, bit for bit
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

/** Returns at most \a enough points, spread evenly, in their order. */
Points someOf(const Points& points, size_t enough) {
  Points some;
  const size_t stride = strideFor(points.size(), enough);
  for (size_t i = 0; i < points.size(); i += stride) some.push_back(points[i]);
  return some;
}

/** Search around a guess, see searchAround(). */
class PoseSearch {
 public:
  PoseSearch(const MapVoxels& a, const Surfaces& surfaces_a, const SurfaceVoxels& b,
             const Eigen::Isometry3d& T_a_b, const SearchParams& params, const Eigen::Vector3d& up)
      : a_(a), params_(params) {
    if (params.isEverywhere())
      walls_.emplace(surfaces_a.normal, b.surfaces.normal, T_a_b, params.wall_share);
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
    lattice_ = {T_a_b, middle, finest_.cell, finest_.cell / radius_, up};
  }

  std::vector<Hypothesis> run() {
    std::vector<ScoreGrid> grids = {ScoreGrid(a_, region_, finest_)};
    const SearchBudget& budget = params_.budget;
    // Scores with few points, or with more points if the cost allows it. Starts at the finest level
    // whose cost is within the budget, then refines the best places level by level.
    Points few = someOf(points_, ScoreGrid::kMostSummed);
    if (work(0, few) > budget.small_work) {
      alignHeights();
      while (few.size() < points_.size() && 2 * work(0, few) <= budget.max_work)
        few = someOf(points_, 2 * few.size());
    }
    unsigned level = 0;
    while (work(level, few) > budget.max_work && level < kMostLevels) {
      grids.push_back(grids.back().coarser());
      level++;
    }
    const size_t kept =
        level > 0 ? budget.kept_places
                  : std::min(budget.kept_places, budget.places_per_hypothesis * params_.hypotheses);
    std::vector<Place> places = exhaustive(grids[level], level, few, kept, same(level));
    while (level-- > 0) places = refine(grids[level], level, few, places);
    return hypotheses(rescored(grids[0], places));
  }

 private:
  std::vector<Hypothesis> hypotheses(const std::vector<Place>& places) const {
    std::vector<Hypothesis> best;
    best.reserve(places.size());
    for (const Place& p : places) best.push_back({lattice_.at(p), static_cast<double>(p.score)});
    return best;
  }

  static constexpr unsigned kMostLevels = 6;

  /** Returns the part of map A that the search needs: places that B's voxels can reach, within the
   * margin around A's obstacles. */
  Eigen::AlignedBox3d region(const Eigen::Isometry3d& T) const {
    const double beside = std::min(params_.translation + params_.height, params_.margin);
    Eigen::AlignedBox3d near_a = box_a_;
    near_a.extend(box_a_.min() - Eigen::Vector3d::Constant(beside));
    near_a.extend(box_a_.max() + Eigen::Vector3d::Constant(beside));
    // The window of a yaw reaches 3 translations. A rotation keeps B within its radius.
    Eigen::AlignedBox3d box_b = boxOf(points_, T);
    const double reach = 3 * params_.translation + (params_.yaw > 0 ? radius_ : 0);
    const Eigen::Vector3d extra(reach, reach, 2 * params_.height);
    box_b.extend(box_b.min() - extra);
    box_b.extend(box_b.max() + extra);
    const Eigen::AlignedBox3d common = near_a.intersection(box_b);
    return common.isEmpty() ? Eigen::AlignedBox3d(box_a_.min(), box_a_.min()) : common;
  }

  /** Returns the side of the cells: at least leastCell(), and so large that the grid stays within
   * SearchBudget::max_cells. It is rounded up to a cube of A's octree. */
  ScoreGrid::Layout layoutFor(double resolution_b) const {
    const double least = std::max(leastCell(params_, a_.voxels.resolution, resolution_b),
                                  std::cbrt(region_.volume() / params_.budget.max_cells));
    ScoreGrid::Layout layout{a_.voxels.resolution, 0};
    while (layout.cell < least * (1 - 1e-9) && layout.level + 1 < OcTreeCube::kMaxDepth) {
      layout.cell *= 2;
      layout.level++;
    }
    return layout;
  }

  /** Moves the lattice to the height at which the layers of obstacles fit best. Otherwise, with
   * wide cells, the floors could miss each other by half a cell at all places of the lattice. */
  void alignHeights() {
    const double step = std::max(a_.voxels.resolution, 0.25 * lattice_.cell);
    const auto layerOf = [step](double z) { return toWhole(std::floor(z / step)); };
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
    const auto floors =
        alignFloors(layers_a, low_a, layers_b, low_b, step, params_.height, params_.floor_share);
    if (!floors) return;  // no common height within the bounds
    heights_ = floors->plausible;
    // If A is tilted, a translation in x and y moves B's floor up or down.
    const double tilted = lattice_.up.head<2>().norm() * 0.5 * box_a_.diagonal().head<2>().norm();
    heights_[0] -= tilted;
    heights_[1] += tilted;
    const Eigen::Vector3d up(0, 0, floors->shift);
    lattice_.T_a_b.pretranslate(up);
    lattice_.middle += up;
  }

  /** Returns the yaws to try: all yaws around a guess; without a guess, yaws that lay walls along
   * walls. */
  std::vector<int> yawsAt(const Lattice& lattice) const {
    const int most = toWhole(std::ceil(std::min(params_.yaw, M_PI) / lattice.yaw_step));
    std::vector<int> yaws;
    for (int yaw = -most; yaw <= most; yaw++)
      if (!walls_ || walls_->arePlausible(yaw * lattice.yaw_step, lattice.yaw_step))
        yaws.push_back(yaw);
    return yaws;
  }

  /** Returns the translations of a yaw. The yaw error of a guess may be a rotation about the origin
   * of B's frame or about the mean of B's points; the mean then lies at different places. The
   * window covers both cases, as far as the maps can overlap. */
  Window windowOf(const Lattice& lattice, int yaw, const Points& points) const {
    const Eigen::Vector3d lever = lattice.middle - lattice.T_a_b.translation();
    const Eigen::Vector3d swing =
        Eigen::AngleAxisd(yaw * lattice.yaw_step, lattice.up) * lever - lever;
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
      w.low[axis] = toWhole(low);
      w.size[axis] = toWhole(std::max(0.0, high - low + 1));
    }
    return w;
  }

  /** Returns the number of additions at a level, estimated from some yaws. */
  double work(unsigned level, const Points& points) const {
    const Lattice lattice = lattice_.level(level);
    const std::vector<int> yaws = yawsAt(lattice);
    constexpr size_t kSample = 16;  // number of windows
    const size_t stride = (yaws.size() + kSample - 1) / kSample;
    double sum = 0, n = 0;
    for (size_t i = 0; i < yaws.size(); i += stride, n++)
      sum += static_cast<double>(windowOf(lattice, yaws[i], points).cells());
    return sum / std::max(n, 1.0) * static_cast<double>(yaws.size() * points.size());
  }

  int stepsOfATurn(unsigned level) const {
    return toWhole(std::round(2 * M_PI / lattice_.level(level).yaw_step));
  }
  Near same(unsigned level) const { return {1, 1, stepsOfATurn(level)}; }
  /** Test for equal final places. */
  Near another() const {
    return {static_cast<int>(params_.distinct_cells),
            toWhole(params_.distinct_yaw / lattice_.yaw_step), stepsOfATurn(0)};
  }

  std::vector<Place> exhaustive(const ScoreGrid& grid, unsigned level, const Points& points,
                                size_t count, const Near& near) const {
    const Lattice lattice = lattice_.level(level);
    const std::vector<int> yaws = yawsAt(lattice);
    std::vector<std::vector<Place>> of_yaw(yaws.size());
    forEachIndex(of_yaw.size(), 1, [&](size_t i) {
      const Window window = windowOf(lattice, yaws[i], points);
      const auto b = cellsOf(grid, points, lattice.turned(yaws[i]));
      of_yaw[i] = mostDistinct(scoreWindow(grid, b, yaws[i], window, params_.conflict_weight),
                               std::min(count, params_.budget.places_per_yaw), near);
    });
    return mostDistinct(concatenated(of_yaw), count, near);
  }

  /** Scores the neighbourhoods of the places of the next coarser level. */
  std::vector<Place> refine(const ScoreGrid& grid, unsigned level, const Points& points,
                            const std::vector<Place>& coarse) const {
    const Lattice lattice = lattice_.level(level);
    std::vector<std::vector<Place>> best(coarse.size());
    forEachIndex(coarse.size(), 1, [&](size_t i) {
      const Place& c = coarse[i];
      const Window window{{2 * c.x - 2, 2 * c.y - 2, 2 * c.z - 2}, {5, 5, 5}};
      std::vector<Place> around;
      for (int yaw = 2 * c.yaw - 1; yaw <= 2 * c.yaw + 1; yaw++) {
        const auto b = cellsOf(grid, points, lattice.turned(yaw));
        const auto places = scoreWindow(grid, b, yaw, window, params_.conflict_weight);
        around.insert(around.end(), places.begin(), places.end());
      }
      best[i] = mostDistinct(std::move(around), 1, same(level));
    });
    return mostDistinct(concatenated(best), params_.budget.kept_places, same(level));
  }

  /** Scores places with all points, at the finest level. */
  std::vector<Place> rescored(const ScoreGrid& grid, const std::vector<Place>& places) const {
    std::map<int, std::vector<Place>> by_yaw;
    for (const Place& p : places) by_yaw[p.yaw].push_back(p);
    const std::vector<std::pair<int, std::vector<Place>>> yaws(by_yaw.begin(), by_yaw.end());
    std::vector<std::vector<Place>> exactly(yaws.size());
    forEachIndex(yaws.size(), 1, [&](size_t i) {
      const auto& [yaw, of_yaw] = yaws[i];
      const auto b = cellsOf(grid, points_, lattice_.turned(yaw));
      for (const Place& p : of_yaw)
        exactly[i].push_back(
            scoreWindow(grid, b, yaw, {{p.x, p.y, p.z}, {1, 1, 1}}, params_.conflict_weight)
                .front());
    });
    return mostDistinct(concatenated(exactly), params_.hypotheses, another());
  }

  static std::vector<Place> concatenated(const std::vector<std::vector<Place>>& lists) {
    std::vector<Place> all;
    for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
  }

  const MapVoxels& a_;
  Points points_;  // points of B
  const SearchParams& params_;
  std::optional<WallDirections> walls_;
  Eigen::AlignedBox3d box_a_, region_;
  std::array<double, 2> heights_{};  // lowest and highest shift of the search, m
  double radius_ = 0;                // radius of B about its mean, horizontal, m
  ScoreGrid::Layout finest_{};
  Lattice lattice_{};
};

}  // namespace

std::vector<Hypothesis> searchAround(const MapVoxels& a, const Surfaces& surfaces_a,
                                     const SurfaceVoxels& b, const Eigen::Isometry3d& T_a_b,
                                     const SearchParams& params, const Eigen::Vector3d& up) {
  if (a.voxels.size() == 0 || b.voxels.size() == 0 || params.translation <= 0 ||
      params.hypotheses == 0)
    return {};
  return PoseSearch(a, surfaces_a, b, T_a_b, params, up).run();
}

double leastCell(const SearchParams& params, double resolution_a, double resolution_b) {
  return std::max({params.cell, 2 * resolution_a, 2 * resolution_b});
}

std::vector<Hypothesis> bestOf(std::vector<Hypothesis> all, const SearchParams& params) {
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& g, const auto& h) { return g.score > h.score; });
  if (all.size() > params.hypotheses) all.resize(params.hypotheses);
  return all;
}

}  // namespace mrpt::fusion
