// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "fusion_core/features/neighbourhoods.h"
#include "fusion_core/map/voxel_blocks.h"

/** \file
 * Algorithm 1, lines 9-16: walks along a surface, from voxel to voxel. */

namespace mrpt::fusion {

/** Walks along the surface around one voxel (Algorithm 1, lines 9-16).
 *
 * A walk stays near the slice that the voxel's normal and the first direction of the walk span. In
 * the slice the surface is a curve. The walk follows it from voxel to voxel. It may turn by a right
 * angle (from a wall onto the floor), but not back. Lengths are in voxels. The coordinates in the
 * slice are the position along the first direction and the height along the normal. */
class SurfaceTracer {
 public:
  SurfaceTracer(const VoxelBlocks& occupied, double distance)
      : occupied_(occupied, static_cast<int>(std::ceil(distance + 2 * kMaxStep))),
        distance_(static_cast<float>(distance)) {}

  void moveTo(const octomap::OcTreeKey& voxel) { occupied_.moveTo(placeOf(voxel)); }

  /** Returns the angle between the vectors to the ends of two walks, rad. The walks leave the voxel
   * along \a tangent and against it. Returns nothing if the surface ends before d_T on a side. */
  std::optional<float> bend(const Eigen::Vector3f& tangent, const Eigen::Vector3f& normal) {
    tangent_ = tangent;
    normal_ = normal;
    lateral_ = normal.cross(tangent);
    const auto t1 = trace({1, 0});
    if (!t1) return std::nullopt;
    const auto t2 = trace({-1, 0});
    if (!t2) return std::nullopt;
    return std::acos(std::clamp(t1->dot(*t2), -1.F, 1.F));
  }

 private:
  using Offset = VoxelBlocks::Offset;
  static constexpr float kMaxStep = 2.3F;      ///< Largest step, crosses gaps of the surface
  static constexpr float kMinStep = 0.5F;      ///< Least step in the slice
  static constexpr float kMinForward = -0.1F;  ///< Cosine of the sharpest turn in one step
  static constexpr float kHalfSlice = 0.75F;   ///< Half thickness, misses no voxel of a surface
  static constexpr float kUnreachable = 1e9F;

  struct Spot {
    Offset offset;          ///< Offset from the first voxel of the walk
    Eigen::Vector2f place;  ///< Offset in the coordinates of the slice
  };

  /** TraceVectorAlongSurfaceVoxels: returns the unit vector to the point where the walk reaches
   * distance d_T. */
  std::optional<Eigen::Vector2f> trace(Eigen::Vector2f direction) {
    Spot at{{0, 0, 0}, {0, 0}};
    const int max_steps = 3 * static_cast<int>(distance_);
    for (int step = 0; step < max_steps; step++) {
      if (at.place.squaredNorm() >= (distance_ - 0.5F) * (distance_ - 0.5F))
        return middleOfSurfaceAt(at).normalized();
      const Eigen::Vector2f before = at.place;
      if (!stepAhead(at, direction) && !stepAcross(at, direction)) return std::nullopt;
      direction = (direction + 2 * (at.place - before)).normalized();
    }
    return std::nullopt;  // the walk circles in clutter
  }

  /** Moves to the voxel nearest to the point one step ahead, among the 8 voxels around that point.
   * Returns false if none of them is occupied. */
  bool stepAhead(Spot& at, const Eigen::Vector2f& direction) {
    const Eigen::Vector2f ahead = at.place + direction;
    const Eigen::Vector3f target = ahead.x() * tangent_ + ahead.y() * normal_;
    Offset low;
    float squared[3][2];  // distances to the lower and the upper voxels, by axis
    unsigned nearest = 0;
    for (unsigned axis = 0; axis < 3; axis++) {
      low[axis] = floorOf(target[axis]);
      const float above = target[axis] - static_cast<float>(low[axis]);
      squared[axis][0] = above * above;
      squared[axis][1] = (1 - above) * (1 - above);
      nearest |= (above > 0.5F ? 1U : 0U) << axis;
    }
    float least = kUnreachable;
    Offset best{};
    for (unsigned flips = 0; flips < 8; flips++) {  // nearest voxel first: usually it is occupied
      const unsigned corner = nearest ^ flips;
      const unsigned x = corner & 1U, y = corner >> 1U & 1U, z = corner >> 2U;
      const float distance = squared[0][x] + squared[1][y] + squared[2][z];
      const Offset next{low[0] + static_cast<int>(x), low[1] + static_cast<int>(y),
                        low[2] + static_cast<int>(z)};
      if (distance >= least || !occupied_.has(next) || next == at.offset ||
          std::abs(toVector(next).dot(lateral_)) > kHalfSlice)
        continue;
      least = distance;
      best = next;
      if (flips == 0) break;
    }
    if (least == kUnreachable) return false;
    at = {best, inSlice(toVector(best))};
    return true;
  }

  /** Moves beside the direction, around a corner or across a gap: to the voxel nearest to the point
   * one step ahead, among all voxels of the slice within the largest step. Returns false if there
   * is no such voxel. */
  bool stepAcross(Spot& at, const Eigen::Vector2f& direction) {
    float least = kUnreachable;
    Spot best = at;
    occupied_.forEachAround(at.offset, stepBall(), [&](const Offset& next) {
      const Eigen::Vector3f offset = toVector(next);
      if (std::abs(offset.dot(lateral_)) > kHalfSlice) return;
      const Eigen::Vector2f place = inSlice(offset), way = place - at.place;
      const float forward = way.dot(direction), squared_length = way.squaredNorm();
      if (squared_length < kMinStep * kMinStep ||
          (forward < 0 && forward * forward > kMinForward * kMinForward * squared_length))
        return;
      constexpr float kNearFirst = 1e-3F;  // prefers the nearer of two equally good voxels
      const float distance = (way - direction).squaredNorm() + kNearFirst * squared_length;
      if (distance >= least) return;
      least = distance;
      best = {next, place};
    });
    at = best;
    return least < kUnreachable;
  }

  /** Returns the mean of the slice's voxels around a place. A single voxel has an error of up to
   * half a voxel, which is 6 deg for a walk of 5 voxels. */
  Eigen::Vector2f middleOfSurfaceAt(const Spot& at) {
    constexpr float kRadius2 = 1.6F * 1.6F;
    static const VoxelBlocks::Ball ball(std::hypot(1.6, 2 * kHalfSlice));
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    int n = 0;
    occupied_.forEachAround(at.offset, ball, [&](const Offset& near) {
      const Eigen::Vector3f offset = toVector(near);
      const Eigen::Vector2f place = inSlice(offset);
      const bool itself = near == at.offset;
      if (!itself && (std::abs(offset.dot(lateral_)) > kHalfSlice ||
                      (place - at.place).squaredNorm() > kRadius2))
        return;
      sum += place;
      n++;
    });
    return sum / static_cast<float>(n);
  }

  static Eigen::Vector3f toVector(const Offset& o) {
    return {static_cast<float>(o[0]), static_cast<float>(o[1]), static_cast<float>(o[2])};
  }
  static const VoxelBlocks::Ball& stepBall() {
    static const VoxelBlocks::Ball ball(kMaxStep);
    return ball;
  }
  static int floorOf(float x) {
    const int i = static_cast<int>(x);
    return i - (x < static_cast<float>(i) ? 1 : 0);
  }
  Eigen::Vector2f inSlice(const Eigen::Vector3f& v) const {
    return {v.dot(tangent_), v.dot(normal_)};
  }

  VoxelBlocks::Window occupied_;
  float distance_;
  Eigen::Vector3f tangent_, normal_, lateral_;
};

}  // namespace mrpt::fusion
