// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/voxels.h>
#include <octomap/OcTree.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "fusion_octree/build.h"

/** \file
 * Small maps and poses for tests. */

namespace mrpt::fusion::test {

inline const Eigen::Isometry3d kIdentity = Eigen::Isometry3d::Identity();
constexpr double kDegree = M_PI / 180;
constexpr float kOccupied = 3.5F;  ///< Log-odds, p = 0.971
constexpr float kFree = -2.0F;     ///< Log-odds, p = 0.119

/** Coordinates of a finest voxel, in voxels from the map's origin. The lowest corner of the voxel
 * is at resolution * (x, y, z). */
using Cell = std::array<int, 3>;

inline octomap::OcTreeKey keyOf(const Cell& c) {
  constexpr int kKeyOfOrigin = 32768;
  return {static_cast<octomap::key_type>(kKeyOfOrigin + c[0]),
          static_cast<octomap::key_type>(kKeyOfOrigin + c[1]),
          static_cast<octomap::key_type>(kKeyOfOrigin + c[2])};
}

inline Eigen::Vector3d centreOf(const Cell& c, double resolution) {
  return resolution * (Eigen::Vector3d(c[0], c[1], c[2]).array() + 0.5).matrix();
}

/** Writes a map voxel by voxel. Log-odds are stored without clamping. */
class MapWriter {
 public:
  explicit MapWriter(double resolution = 0.1)
      : tree_(std::make_unique<octomap::OcTree>(resolution)) {}

  /** Sets the box of the following writes (corners included). Voxels outside of it are skipped. */
  MapWriter& within(const Cell& low, const Cell& high) {
    low_ = low;
    high_ = high;
    return *this;
  }

  MapWriter& voxel(const Cell& c, float log_odds) {
    for (int axis = 0; axis < 3; axis++)
      if (c[axis] < low_[axis] || c[axis] > high_[axis]) return *this;
    tree_->setNodeValue(keyOf(c), 0.F, true)->setLogOdds(log_odds);
    return *this;
  }

  /** Writes all voxels of a box, both corners included. */
  MapWriter& box(const Cell& low, const Cell& high, float log_odds) {
    for (int x = low[0]; x <= high[0]; x++)
      for (int y = low[1]; y <= high[1]; y++)
        for (int z = low[2]; z <= high[2]; z++) voxel({x, y, z}, log_odds);
    return *this;
  }

  /** Writes the 6 faces of a box, 1 voxel thick. */
  MapWriter& shell(const Cell& low, const Cell& high, float log_odds) {
    for (int axis = 0; axis < 3; axis++) {
      Cell top = high, bottom = low;
      top[axis] = low[axis];
      bottom[axis] = high[axis];
      box(low, top, log_odds).box(bottom, high, log_odds);
    }
    return *this;
  }

  std::unique_ptr<octomap::OcTree> unpruned() {
    tree_->updateInnerOccupancy();
    return std::move(tree_);
  }
  std::unique_ptr<octomap::OcTree> pruned() {
    auto tree = unpruned();
    tree->prune();
    return tree;
  }

 private:
  std::unique_ptr<octomap::OcTree> tree_;
  Cell low_{-32768, -32768, -32768}, high_{32767, 32767, 32767};
};

/** A map of one leaf, at the root: 2^48 voxels. */
inline std::unique_ptr<octomap::OcTree> rootLeaf(float log_odds) {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  mrpt::fusion::OcTreeAccess::createRoot(*tree)->setLogOdds(log_odds);
  return tree;
}

/** Occupied voxels without an octree. */
inline OccupiedVoxels voxelsAt(const std::vector<Cell>& cells, double resolution,
                               float probability = 0.9F) {
  OccupiedVoxels v;
  v.resolution = resolution;
  for (const Cell& c : cells) {
    v.centre.push_back(centreOf(c, resolution).cast<float>());
    v.probability.push_back(probability);
    v.key.push_back(keyOf(c));
  }
  return v;
}

/** Returns a pose from lengths in m and angles in deg, in MRPT's order: yaw, pitch, roll. */
inline Eigen::Isometry3d poseOf(double x, double y, double z, double yaw, double pitch = 0,
                                double roll = 0) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << x, y, z;
  T.linear() = (Eigen::AngleAxisd(yaw * kDegree, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(pitch * kDegree, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(roll * kDegree, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return T;
}

inline double metresBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}
inline double degreesBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() / kDegree;
}

/** Returns the part of an apartment between two corners. The apartment has 3 rooms, 10 x 7 x 2.6 m
 * at 0.1 m, without symmetry. Walls, floor, ceiling and furniture are occupied. The air is free.
 * The inside of furniture is unknown. */
inline std::unique_ptr<octomap::OcTree> apartment(const Cell& low = {0, 0, 0},
                                                  const Cell& high = {99, 69, 25}) {
  struct Box {
    Cell low, high;
  };
  const std::vector<Box> furniture = {{{10, 8, 0}, {22, 16, 7}},   {{1, 20, 0}, {6, 32, 19}},
                                      {{42, 4, 0}, {49, 13, 10}},  {{30, 52, 0}, {38, 68, 8}},
                                      {{60, 40, 0}, {72, 47, 12}}, {{78, 20, 0}, {81, 23, 25}},
                                      {{92, 45, 0}, {98, 60, 17}}};
  MapWriter map(0.1);
  map.within(low, high);
  for (int x = 1; x < 99; x++)
    for (int y = 1; y < 69; y++)
      for (int z = 1; z < 25; z++)
        if (std::none_of(furniture.begin(), furniture.end(), [&](const Box& f) {
              return x >= f.low[0] && x <= f.high[0] && y >= f.low[1] && y <= f.high[1] &&
                     z >= f.low[2] && z <= f.high[2];
            }))
          map.voxel({x, y, z}, kFree);
  for (const Box& f : furniture) map.shell(f.low, f.high, kOccupied);
  map.shell({0, 0, 0}, {99, 69, 25}, kOccupied);
  // Inner walls, each with a door.
  map.box({55, 0, 0}, {55, 69, 25}, kOccupied).box({55, 28, 1}, {55, 37, 20}, kFree);
  map.box({0, 42, 0}, {54, 42, 25}, kOccupied).box({20, 42, 1}, {28, 42, 20}, kFree);
  return map.pruned();
}

/** Visitor of a random octree: splits cubes at random, down to finest voxels. Leaves are unknown,
 * free or occupied, with random log-odds. */
class RandomVisitor {
 public:
  static constexpr int kSide = 128;  ///< Side of the cube with known space, voxels
  static constexpr octomap::key_type kLow = 32768 - kSide / 2;

  struct State {};
  State descend(const State&, unsigned, const mrpt::fusion::OcTreeCube&) const { return {}; }
  mrpt::fusion::OcTreeFill visit(const mrpt::fusion::OcTreeCube& cube, const State&) {
    using mrpt::fusion::OcTreeFill;
    for (const octomap::key_type low : {cube.key[0], cube.key[1], cube.key[2]})
      if (low + cube.side() <= kLow || low >= kLow + kSide) return OcTreeFill::unknown();
    if (cube.side() >= kSide) return OcTreeFill::split();
    const auto what = random_() % 8;
    if (what < 4 && cube.depth < mrpt::fusion::OcTreeCube::kMaxDepth) return OcTreeFill::split();
    if (what == 7) return OcTreeFill::unknown();
    const auto sure = 0.01F * static_cast<float>(1 + random_() % 300);
    return OcTreeFill::leaf(what % 4 == 0 ? sure : -sure);
  }

 private:
  std::mt19937 random_{5};
};

/** Returns a random octree with leaves of all sizes. */
inline std::unique_ptr<octomap::OcTree> randomTree() {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  RandomVisitor visitor;
  mrpt::fusion::buildOcTree(*tree, {}, visitor);
  return tree;
}

/** Calls \a f with at most \a threads threads of TBB. */
template <class F>
auto withThreads(size_t threads, F&& f) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return f();
}

}  // namespace mrpt::fusion::test
