// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Converts the known space of an octree to arrays of cubes, and back. */
#include <mrpt/fusion/voxels.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <tuple>

#include "fusion_base/parallel.h"
#include "fusion_octree/build.h"
#include "fusion_octree/resolution.h"
#include "fusion_octree/walk.h"

namespace mrpt::fusion {
namespace {

/** A node of an octree with its cube. */
struct PlacedNode {
  const octomap::OcTreeNode* node;
  OcTreeCube cube;
};

/** Returns nodes that contain all leaves, in the order of the octree: enough for all threads. */
std::vector<PlacedNode> partsOf(const octomap::OcTree& map) {
  constexpr size_t kEnough = 256;
  std::vector<PlacedNode> parts;
  if (map.getRoot()) parts.push_back({map.getRoot(), {}});
  for (unsigned depth = 0; depth < OcTreeCube::kMaxDepth && parts.size() < kEnough; depth++) {
    std::vector<PlacedNode> finer;
    for (const PlacedNode& p : parts) {
      if (!OcTreeAccess::hasChildren(*p.node)) finer.push_back(p);
      for (unsigned i = 0; OcTreeAccess::hasChildren(*p.node) && i < 8; i++)
        if (const auto* child = OcTreeAccess::child(*p.node, i))
          finer.push_back({child, p.cube.child(i)});
    }
    parts = std::move(finer);
  }
  return parts;
}

void addLeaf(const octomap::OcTreeNode& leaf, const OcTreeCube& cube, Cubes& cubes) {
  const double half = 0.5 * cube.side();
  const auto centre = [&](unsigned axis) {
    return static_cast<float>(cubes.resolution * (cube.key[axis] + half - 32768));
  };
  cubes.centre.emplace_back(centre(0), centre(1), centre(2));
  cubes.log_odds.push_back(leaf.getLogOdds());
  cubes.size.push_back(static_cast<float>(cubes.resolution * cube.side()));
}

Cubes cubesOf(const octomap::OcTree& map, const PlacedNode& part, KnownSpace wanted) {
  Cubes cubes;
  cubes.resolution = map.getResolution();
  const auto add = [&](const OcTreeCube& cube, const octomap::OcTreeNode& leaf) {
    if (wanted == KnownSpace::All || map.isNodeOccupied(leaf) == (wanted == KnownSpace::Occupied))
      addLeaf(leaf, cube, cubes);
  };
  if (OcTreeAccess::hasChildren(*part.node))
    detail::forEachLeafBelow(*part.node, part.cube, add);
  else
    add(part.cube, *part.node);
  return cubes;
}

/** A cube by its place in the order of the octree. */
struct OrderedCube {
  uint64_t place;   // of its lowest finest voxel, in the order of the octree
  uint64_t volume;  // number of finest voxels
  float log_odds;
  size_t index;  // of the caller's cube
};

/** Inverts keyInOctreeOrder(). */
uint64_t placeOf(const octomap::OcTreeKey& key) {
  uint64_t place = 0;
  for (unsigned bit = 0; bit < OcTreeCube::kMaxDepth; bit++)
    for (unsigned axis = 0; axis < 3; axis++)
      place |= uint64_t{key[axis] >> bit & 1U} << (3 * bit + axis);
  return place;
}

[[noreturn]] void throwFault(size_t index, const std::string& fault) {
  throw std::invalid_argument("cube " + std::to_string(index) + " " + fault);
}

/** Returns the height of a cube above the finest depth. */
unsigned heightOf(const Cubes& cubes, size_t i) {
  if (cubes.size.empty()) return 0;
  constexpr double kTolerance = 1e-3;
  const double sides = static_cast<double>(cubes.size[i]) / cubes.resolution;
  const double height = std::log2(sides);
  if (!(height > -kTolerance && height < OcTreeCube::kMaxDepth + kTolerance) ||
      std::abs(height - std::round(height)) > kTolerance)
    throwFault(i, "has a size that is not the voxel size times a power of 2 up to 65536");
  return static_cast<unsigned>(std::lround(height));
}

OrderedCube orderedCube(const Cubes& cubes, size_t i) {
  constexpr double kOrigin = 32768;
  if (!std::isfinite(cubes.log_odds[i])) throwFault(i, "has log-odds that are not finite");
  octomap::OcTreeKey key;
  for (unsigned axis = 0; axis < 3; axis++) {
    const double k =
        std::floor(static_cast<double>(cubes.centre[i][axis]) / cubes.resolution) + kOrigin;
    if (!(k >= 0 && k < 2 * kOrigin)) throwFault(i, "is outside the grid of an octree");
    key[axis] = static_cast<octomap::key_type>(k);
  }
  const uint64_t volume = uint64_t{1} << (3 * heightOf(cubes, i));
  return {placeOf(key) / volume * volume, volume, cubes.log_odds[i], i};
}

/** Sorts the cubes in the order of the octree. */
std::vector<OrderedCube> ordered(const Cubes& cubes) {
  std::vector<OrderedCube> sorted;
  sorted.reserve(cubes.count());
  for (size_t i = 0; i < cubes.count(); i++) sorted.push_back(orderedCube(cubes, i));
  tbb::parallel_sort(sorted, [](const OrderedCube& a, const OrderedCube& b) {
    return std::tie(a.place, a.volume, a.index) < std::tie(b.place, b.volume, b.index);
  });
  for (size_t i = 1; i < sorted.size(); i++)
    if (sorted[i].place < sorted[i - 1].place + sorted[i - 1].volume)
      throwFault(sorted[i].index, "overlaps cube " + std::to_string(sorted[i - 1].index));
  return sorted;
}

/** Builds the octree of sorted cubes. The state is the range of the cubes in a cube. */
class OrderedCubesVisitor {
 public:
  struct State {
    const OrderedCube *begin, *end;
    uint64_t place;  // of the cube
  };

  explicit OrderedCubesVisitor(const std::vector<OrderedCube>& cubes) : cubes_(&cubes) {}
  State rootState() const { return {cubes_->data(), cubes_->data() + cubes_->size(), 0}; }
  static uint64_t volumeOf(const OcTreeCube& cube) {
    return uint64_t{1} << (3 * (OcTreeCube::kMaxDepth - cube.depth));
  }
  static OcTreeFill visit(const OcTreeCube& cube, const State& s) {
    if (s.begin == s.end) return OcTreeFill::unknown();
    return s.begin->volume >= volumeOf(cube) ? OcTreeFill::leaf(s.begin->log_odds)
                                             : OcTreeFill::split();
  }
  static State descend(const State& s, unsigned i, const OcTreeCube& child) {
    const uint64_t volume = volumeOf(child), low = s.place + i * volume;
    const auto first = [&](uint64_t place) {
      return std::lower_bound(s.begin, s.end, place,
                              [](const OrderedCube& c, uint64_t p) { return c.place < p; });
    };
    return {first(low), first(low + volume), low};
  }

 private:
  const std::vector<OrderedCube>* cubes_;
};

}  // namespace

Cubes cubesOf(const octomap::OcTree& map, KnownSpace part) {
  const std::vector<PlacedNode> nodes = partsOf(map);
  std::vector<Cubes> parts(nodes.size());
  forEachIndex(nodes.size(), 1, [&](size_t i) { parts[i] = cubesOf(map, nodes[i], part); });

  std::vector<size_t> first{0};
  for (const Cubes& p : parts) first.push_back(first.back() + p.count());
  Cubes all;
  all.resolution = map.getResolution();
  all.centre.resize(first.back());
  all.log_odds.resize(first.back());
  all.size.resize(first.back());
  forEachIndex(parts.size(), 1, [&](size_t i) {
    const auto at = static_cast<std::ptrdiff_t>(first[i]);
    const Cubes p = std::move(parts[i]);  // frees the part as soon as it is copied
    std::copy(p.centre.begin(), p.centre.end(), all.centre.begin() + at);
    std::copy(p.log_odds.begin(), p.log_odds.end(), all.log_odds.begin() + at);
    std::copy(p.size.begin(), p.size.end(), all.size.begin() + at);
  });
  return all;
}

std::unique_ptr<octomap::OcTree> octreeOf(const Cubes& cubes) {
  checkResolution(cubes.resolution);
  if (cubes.log_odds.size() != cubes.count() ||
      (!cubes.size.empty() && cubes.size.size() != cubes.count()))
    throw std::invalid_argument("centres, log-odds and sizes are not of the same number");
  auto tree = std::make_unique<octomap::OcTree>(cubes.resolution);
  buildOcTreeInParallel(*tree, OrderedCubesVisitor(ordered(cubes)));
  return tree;
}

}  // namespace mrpt::fusion
