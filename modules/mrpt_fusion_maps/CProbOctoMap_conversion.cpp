// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CProbOctoMap: conversion from and to the octomaps of MRPT, with colours, and from any map. */

#include <mrpt/fusion/compat.h>
#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap3D.h>
#include <mrpt/maps/CProbOctoMap.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "fusion_octree/build.h"
#include "fusion_octree/walk.h"

using namespace mrpt::fusion;
using namespace mrpt::maps;

// ---------------------------------------------------------------- COctoMap, CColouredOctoMap

namespace {

double probability(float log_odds) {
  return 1.0 / (1.0 + std::exp(-static_cast<double>(log_odds)));
}

/** Largest log-odds with a probability other than 0 and 1 in double precision. */
constexpr float kMaxLogOdds = 36.0F;

/** Returns the probability that OctoMap converts to these log-odds. If no double gives exactly
 * these log-odds, returns the nearest. */
double exactProbability(float log_odds) {
  ASSERTMSG_(std::abs(log_odds) <= kMaxLogOdds,
             "CProbOctoMap: log-odds too large for a probability in MRPT's octomaps");
  const double p = probability(log_odds);
  for (const double candidate : {p, std::nextafter(p, 0.0), std::nextafter(p, 1.0)})
    if (octomap::logodds(candidate) == log_odds) return candidate;
  return p;
}

/** A leaf: its cube and its value. */
struct LeafCube {
  OcTreeCube cube;
  float log_odds;
};

/** Builds a tree from a list of leaves. Each level distributes the leaves of a cube to its
 * children. */
class LeafListVisitor {
 public:
  struct State {
    std::vector<LeafCube> leaves;
  };
  OcTreeFill visit(const OcTreeCube& cube, const State& s) const {
    if (s.leaves.empty()) return OcTreeFill::unknown();
    if (s.leaves.front().cube.depth == cube.depth)
      return OcTreeFill::leaf(s.leaves.front().log_odds);
    return OcTreeFill::split();
  }
  State descend(State& parent, unsigned, const OcTreeCube& child) const {
    State s;
    const auto rest = std::partition(parent.leaves.begin(), parent.leaves.end(),
                                     [&](const LeafCube& l) { return !child.contains(l.cube); });
    s.leaves.assign(rest, parent.leaves.end());
    parent.leaves.erase(rest, parent.leaves.end());
    return s;
  }
};

/** Returns a tree with the leaves and the sensor model of an octomap of MRPT. */
template <class TheirMap>
std::unique_ptr<octomap::OcTree> treeOf(const TheirMap& o) {
  // Only the drawing API returns leaf cubes, and renderingOptions decide which it returns.
  viz::COctoMapVoxels voxels;
  const auto& drawn = o.renderingOptions;
  if (drawn.generateOccupiedVoxels && drawn.generateFreeVoxels) {
    o.getAsOctoMapVoxels(voxels);
  } else {
    TheirMap copy(o);  // loses the colours, which are not needed here
    copy.renderingOptions = {};
    copy.getAsOctoMapVoxels(voxels);
  }

  auto tree = std::make_unique<octomap::OcTree>(o.getResolution());
  OcTreeAccess::setSensorModel(
      *tree, {o.getClampingThresMinLog(), o.getClampingThresMaxLog(), o.getProbHitLog(),
              o.getProbMissLog(), o.getOccupancyThresLog()});
  LeafListVisitor::State leaves;
  for (const size_t set : {viz::VOXEL_SET_OCCUPIED, viz::VOXEL_SET_FREESPACE})
    for (size_t i = 0; i < voxels.getVoxelCount(set); i++) {
      const auto& v = voxels.getVoxel(set, i);
      const double levels = std::log2(v.side_length / o.getResolution());
      const auto depth = static_cast<unsigned>(OcTreeCube::kMaxDepth - std::lround(levels));
      double p = 0;
      OcTreeCube cube{{0, 0, 0}, depth};
      const bool known =
          depth <= OcTreeCube::kMaxDepth &&
          o.getPointOccupancy(v.coords.x, v.coords.y, v.coords.z, p) &&
          tree->coordToKeyChecked(v.coords.x, v.coords.y, v.coords.z, depth, cube.key);
      ASSERTMSG_(known, "CProbOctoMap: a voxel of the octomap does not lie on an octree's grid");
      const uint32_t lowest = ~(cube.side() - 1U);
      for (unsigned axis = 0; axis < 3; axis++)
        cube.key[axis] = static_cast<octomap::key_type>(cube.key[axis] & lowest);
      // MRPT rounds the probability of a saturated voxel to 0 or 1.
      constexpr double kTiny = 1e-16;
      leaves.leaves.push_back({cube, octomap::logodds(std::clamp(p, kTiny, 1 - kTiny))});
    }
  LeafListVisitor visitor;
  buildOcTree(*tree, std::move(leaves), visitor);
  return tree;
}

/** Copies options. Each map class has its own option types, with the same fields. */
template <class From, class To>
void copyOptions(const From& from, To& to) {
  to.genericMapParams = from.genericMapParams;
  to.likelihoodOptions.decimation = from.likelihoodOptions.decimation;
  to.renderingOptions.generateGridLines = from.renderingOptions.generateGridLines;
  to.renderingOptions.generateOccupiedVoxels = from.renderingOptions.generateOccupiedVoxels;
  to.renderingOptions.visibleOccupiedVoxels = from.renderingOptions.visibleOccupiedVoxels;
  to.renderingOptions.generateFreeVoxels = from.renderingOptions.generateFreeVoxels;
  to.renderingOptions.visibleFreeVoxels = from.renderingOptions.visibleFreeVoxels;
  to.insertionOptions.maxrange = from.insertionOptions.maxrange;
  to.insertionOptions.pruning = from.insertionOptions.pruning;
}

/** Fills an empty octomap of MRPT with the leaves, the sensor model and the options of a map. */
template <class TheirMap>
void fill(TheirMap& result, const CProbOctoMap& map) {
  const octomap::OcTree& tree = map.octree();
  // Each voxel gets one hit or miss of exactly the wanted strength. The thresholds are so wide that
  // nothing is clamped.
  constexpr double kTiny = 1e-16;
  result.setClampingThresMin(kTiny);
  result.setClampingThresMax(1 - kTiny);
  forEachLeaf(tree, [&](const OcTreeCube& cube, const octomap::OcTreeNode& node) {
    const float log_odds = node.getLogOdds();
    const bool hit = log_odds >= 0;
    if (hit)
      result.setProbHit(exactProbability(log_odds));
    else
      result.setProbMiss(exactProbability(log_odds));
    forEachVoxel(cube, [&](const octomap::OcTreeKey& key) {
      result.updateVoxel(tree.keyToCoord(key[0]), tree.keyToCoord(key[1]), tree.keyToCoord(key[2]),
                         hit);
    });
  });
  result.setOccupancyThres(tree.getOccupancyThres());
  result.setProbHit(tree.getProbHit());
  result.setProbMiss(tree.getProbMiss());
  result.setClampingThresMin(tree.getClampingThresMin());
  result.setClampingThresMax(tree.getClampingThresMax());
  copyOptions(map, result);
}

}  // namespace

CProbOctoMap::CProbOctoMap(const COctoMap& o) { fromOctoMap(o); }
CProbOctoMap::CProbOctoMap(const CColouredOctoMap& o) { fromOctoMap(o); }

void CProbOctoMap::fromOctoMap(const COctoMap& o) {
  setOctree(treeOf(o));
  copyOptions(o, *this);
}

void CProbOctoMap::fromOctoMap(const CColouredOctoMap& o) {
  setOctree(treeOf(o));
  copyOptions(o, *this);
}

void CProbOctoMap::toOctoMap(COctoMap& o) const {
  COctoMap result(getResolution());
  fill(result, *this);
  o = result;
}

// ---------------------------------------------------------------- colours

namespace {

using Colour = std::array<uint8_t, 3>;
using mrpt::math::TPoint3D;

/** Returns the colour of the occupied voxel at a point of the frame of a map, m. */
std::optional<Colour> colourAt(const CColouredOctoMap& map, float x, float y, float z) {
  constexpr Colour kUnset = {255, 255, 255};  // default of octomap
  double occupancy = 0;
  Colour c = kUnset;
  if (!map.getPointOccupancy(x, y, z, occupancy) || occupancy < map.getOccupancyThres() ||
      !map.getPointColour(x, y, z, c[0], c[1], c[2]) || c == kUnset)
    return std::nullopt;
  return c;
}

/** Returns the colour of the coloured, occupied voxel whose centre is nearest to a point of the
 * frame of a map. Returns nothing if no such centre is within \a reach, m. */
std::optional<Colour> nearestColour(const CColouredOctoMap& map, const TPoint3D& p, double reach) {
  const auto colourOf = [&](double x, double y, double z) {
    return colourAt(map, static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
  };
  if (const auto here = colourOf(p.x, p.y, p.z)) return here;  // no other centre is nearer
  const double voxel = map.getResolution();
  const auto centre = [&](double v, int offset) {
    return (std::floor(v / voxel) + 0.5 + offset) * voxel;
  };
  const int n = static_cast<int>(std::ceil(reach / voxel));
  std::optional<Colour> nearest;
  double nearest_distance = reach;
  for (int i = -n; i <= n; i++)
    for (int j = -n; j <= n; j++)
      for (int k = -n; k <= n; k++) {
        const double x = centre(p.x, i), y = centre(p.y, j), z = centre(p.z, k);
        const double dx = x - p.x, dy = y - p.y, dz = z - p.z;
        const double distance = std::sqrt(dx * dx + dy * dy + dz * dz);
        if (distance > nearest_distance) continue;
        if (const auto colour = colourOf(x, y, z)) {
          nearest = colour;
          nearest_distance = distance;
        }
      }
  return nearest;
}

/** The mean of colours. */
class MeanColour {
 public:
  void add(const Colour& c) {
    for (size_t i = 0; i < 3; i++) sum_[i] += c[i];
    count_++;
  }
  std::optional<Colour> get() const {
    if (!count_) return std::nullopt;
    Colour mean;
    for (size_t i = 0; i < 3; i++) mean[i] = static_cast<uint8_t>((sum_[i] + count_ / 2) / count_);
    return mean;
  }

 private:
  std::array<size_t, 3> sum_{};
  size_t count_ = 0;
};

}  // namespace

std::shared_ptr<CColouredOctoMap> CProbOctoMap::toColouredOctoMap(
    const std::vector<ColourSource>& sources) const {
  auto result = std::make_shared<CColouredOctoMap>(getResolution());
  fill(*result, *this);
  const auto method = result->getVoxelColourMethod();
  result->setVoxelColourMethod(CColouredOctoMap::SET);
  // MRPT has pruned the tree that was filled, and a leaf has one colour.
  octomap::OcTree pruned(*m_octree);
  pruned.prune();
  const auto centre = [&](const octomap::OcTreeKey& key) {
    return TPoint3D(pruned.keyToCoord(key[0]), pruned.keyToCoord(key[1]),
                    pruned.keyToCoord(key[2]));
  };
  forEachLeaf(pruned, [&](const OcTreeCube& cube, const octomap::OcTreeNode& node) {
    if (!pruned.isNodeOccupied(node)) return;
    MeanColour mean;
    forEachVoxel(cube, [&](const octomap::OcTreeKey& key) {
      for (const auto& source : sources) {
        const double voxel = std::max(getResolution(), source.map.getResolution());
        const auto colour = nearestColour(source.map, source.pose.inverseComposePoint(centre(key)),
                                          0.5 * std::sqrt(3.0) * voxel);
        if (colour) mean.add(*colour);
      }
    });
    const auto at = centre(cube.key);
    if (const auto colour = mean.get())
      result->updateVoxelColour(at.x, at.y, at.z, (*colour)[0], (*colour)[1], (*colour)[2]);
  });
  result->setVoxelColourMethod(method);
  return result;
}

// ---------------------------------------------------------------- any map

namespace {

/** Returns the octomap of a map of one class. Returns null for maps of other classes. */
using View = std::shared_ptr<const CProbOctoMap> (*)(const CMetricMap&);

std::shared_ptr<const CProbOctoMap> itself(const CMetricMap& map) {
  const auto* ours = dynamic_cast<const CProbOctoMap*>(&map);
  return {std::shared_ptr<const CProbOctoMap>(), ours};  // not owned
}

template <class Map>
std::shared_ptr<const CProbOctoMap> converted(const CMetricMap& map) {
  const auto* theirs = dynamic_cast<const Map*>(&map);
  return theirs ? std::make_shared<const CProbOctoMap>(*theirs) : nullptr;
}

/** Returns the octomap of a map, or of the first map of a set for which there is one. */
std::shared_ptr<const CProbOctoMap> findIn(const CMetricMap& map, View view) {
  if (auto found = view(map)) return found;
  if (const auto* several = dynamic_cast<const CMultiMetricMap*>(&map))
    for (const auto& m : several->maps)
      if (auto found = findIn(*m, view)) return found;
  return nullptr;
}

}  // namespace

std::shared_ptr<const CProbOctoMap> mrpt::fusion::asProbOctoMap(const CMetricMap& map) {
  // The class that keeps most information comes first, not the first map of a set.
  for (const auto view : {&itself, &converted<COctoMap>, &converted<CColouredOctoMap>,
                          &converted<COccupancyGridMap3D>})
    if (auto found = findIn(map, view)) return found;
  return nullptr;
}

std::shared_ptr<const CProbOctoMap> mrpt::fusion::asProbOctoMap(const CMetricMap::ConstPtr& map) {
  const auto octomap = asProbOctoMap(*map);
  if (!octomap) return nullptr;
  return {std::make_shared<std::pair<CMetricMap::ConstPtr, decltype(octomap)>>(map, octomap),
          octomap.get()};
}
