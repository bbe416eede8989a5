// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Cuts slices out of maps. */

#include "fusion_octree/slice.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "fusion_octree/walk.h"

namespace mrpt::fusion {
namespace {

constexpr int64_t kKeys = int64_t{1} << OcTreeCube::kMaxDepth;

/** Voxels by their keys: first and last. Empty if the first is behind the last. */
struct KeyRange {
  int64_t first = kKeys, last = -1;

  bool empty() const { return first > last; }
  int64_t size() const { return last - first + 1; }
  void add(int64_t from, int64_t to) {
    first = std::min(first, from);
    last = std::max(last, to);
  }
  bool meets(int64_t from, int64_t side) const {
    return !empty() && from <= last && from + side > first;
  }
};

/** Returns the voxels whose centre is between two heights. */
KeyRange keysBetween(double low, double high, double resolution) {
  constexpr double kRounding = 1e-6;  // voxels; a height on a centre is between the heights
  const auto keyOf = [&](double height) { return height / resolution - 0.5 + kKeys / 2; };
  const auto clamped = [](double key) {
    return static_cast<int64_t>(std::clamp(key, -1.0, static_cast<double>(kKeys)));
  };
  return {std::max<int64_t>(clamped(std::ceil(keyOf(low) - kRounding)), 0),
          std::min(clamped(std::floor(keyOf(high) + kRounding)), kKeys - 1)};
}

/** Writes the columns of a map to cells. All nodes above a square of cells are visited together,
 * from the root down. So a square below a large leaf alone is written at once. */
class Projection {
 public:
  Projection(KeyRange heights, KeyRange x, KeyRange y, MapSlice& slice)
      : heights_(heights), x_(x), y_(y), slice_(slice) {}

  void add(const octomap::OcTreeNode& root) {
    above_.push_back({&root, 0});
    project({0, 0, 0}, 0, MapSlice::kUnknown);
  }

 private:
  struct Square {
    int64_t x, y;
    unsigned depth;

    int64_t side() const { return kKeys >> depth; }
    Square quarter(unsigned i) const {
      const int64_t half = side() / 2;
      return {x + (i & 1U ? half : 0), y + (i & 2U ? half : 0), depth + 1};
    }
  };
  /** A node above a square, of the depth of the square. */
  struct Above {
    const octomap::OcTreeNode* node;
    int64_t z;  // key of its lowest voxel
  };

  /** Writes the cells of a square. \param[in] first First node above the square in above_; all
   * nodes behind it are above the square, too. \param[in] value Highest log-odds of the leaves
   * above larger squares. */
  void project(const Square& square, size_t first, float value) {
    const size_t end = above_.size();
    bool has_children = false;
    for (size_t i = first; i < end; i++) {
      const auto& node = *above_[i].node;
      if (OcTreeAccess::hasChildren(node))
        has_children = true;
      else
        value = std::max(value, node.getLogOdds());
    }
    if (!has_children) return fill(square, value);
    for (unsigned q = 0; q < 4; q++) {
      const Square quarter = square.quarter(q);
      for (size_t i = first; i < end; i++) addChildren(above_[i], quarter, q);
      if (above_.size() > end)
        project(quarter, end, value);
      else
        fill(quarter, value);
      above_.resize(end);
    }
  }

  /** Adds the lower and the upper child of a node above a quarter of its square. */
  void addChildren(const Above above, const Square& quarter, unsigned q) {
    if (!OcTreeAccess::hasChildren(*above.node)) return;
    for (unsigned upper = 0; upper < 2; upper++) {
      const int64_t z = above.z + (upper ? quarter.side() : 0);
      const auto* child = OcTreeAccess::child(*above.node, q | upper << 2U);
      if (child && heights_.meets(z, quarter.side())) above_.push_back({child, z});
    }
  }

  void fill(const Square& square, float value) {
    if (value == MapSlice::kUnknown) return;
    for (int64_t y = square.y; y < square.y + square.side(); y++) {
      const auto row = slice_.log_odds.begin() + (y - y_.first) * x_.size();
      std::fill_n(row + (square.x - x_.first), square.side(), value);
    }
  }

  KeyRange heights_, x_, y_;
  MapSlice& slice_;
  std::vector<Above> above_;  // a stack: the nodes above each square on the way from the root
};

}  // namespace

MapSlice sliceOf(const octomap::OcTree& map, double low, double high) {
  const KeyRange heights = keysBetween(low, high, map.getResolution());
  KeyRange x, y;
  forEachLeaf(map, [&](const OcTreeCube& cube, const octomap::OcTreeNode&) {
    if (!heights.meets(cube.key[2], cube.side())) return;
    x.add(cube.key[0], cube.key[0] + cube.side() - 1);
    y.add(cube.key[1], cube.key[1] + cube.side() - 1);
  });
  MapSlice slice;
  slice.resolution = map.getResolution();
  if (x.empty()) return slice;
  constexpr int64_t kMostCells = int64_t{1} << 27U;
  if (x.size() * y.size() > kMostCells)
    throw std::length_error("a slice has " + std::to_string(x.size()) + " x " +
                            std::to_string(y.size()) + " cells, more than " +
                            std::to_string(kMostCells));
  const auto coordinate = [&](int64_t key) {
    return static_cast<double>(key - kKeys / 2) * map.getResolution();
  };
  slice.low_x = coordinate(x.first);
  slice.low_y = coordinate(y.first);
  slice.width = static_cast<size_t>(x.size());
  slice.height = static_cast<size_t>(y.size());
  slice.log_odds.assign(slice.width * slice.height, MapSlice::kUnknown);
  Projection(heights, x, y, slice).add(*map.getRoot());
  return slice;
}

}  // namespace mrpt::fusion
