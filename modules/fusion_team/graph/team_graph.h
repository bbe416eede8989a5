// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "fusion_team/pairs/pair_evidence.h"

/** \file
 * The graph of a team: maps, and poses in which pairs of maps may lie. */

namespace mrpt::fusion {

/** A hypothesis of a pair: a pose in which two maps may lie. */
struct Way {
  size_t a = 0;                                             ///< Index of map A
  size_t b = 0;                                             ///< Index of map B; larger than a
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< Pose of map B in A's frame
};

/** The hypotheses of all pairs of a team, found by map. */
struct TeamWays {
  TeamWays(std::vector<Way> ways, size_t maps) : all(std::move(ways)), of(maps) {
    for (size_t i = 0; i < all.size(); i++)
      for (const size_t k : {all[i].a, all[i].b}) of[k].push_back(i);
  }
  /** Returns the number of maps. */
  size_t n() const { return of.size(); }
  /** True if two maps have a hypothesis. */
  bool connects(size_t i, size_t j) const {
    return std::any_of(of[i].begin(), of[i].end(),
                       [&](size_t w) { return all[w].a == j || all[w].b == j; });
  }

  std::vector<Way> all;
  std::vector<std::vector<size_t>> of;  ///< Indices of the ways of each map
};

/** Shares of conflicts at which confirmed obstacles count nothing. Drift bends maps, so that a
 * right configuration has displaced obstacles. It has hardly any contradicted obstacles. */
struct ConflictTolerance {
  double displaced;     ///< See ComparedObstacles::displaced
  double contradicted;  ///< See ComparedObstacles::contradicted
  /** Of a pair at the pose of its sure match, see TeamEvidence::isSure(): the verdict on the pair
   * has weighed these conflicts, so one of them counts no more than one confirmed obstacle. */
  double explained = 1;
};

/** Evidence of all pairs of a team, by the indices of both maps. Several threads may use it. */
class TeamEvidence {
 public:
  virtual ~TeamEvidence() = default;
  /** Returns the number of maps. */
  virtual size_t size() const = 0;
  /** Returns the evidence of maps a < b near a pose. */
  virtual const PairEvidence& near(size_t a, size_t b, const Eigen::Isometry3d& T_a_b) const = 0;
  /** Returns the covariance of maps a < b at their registered pose, see PairEvidence::registered
   * and MatchResult::covariance. */
  virtual Matrix6d covariance(size_t a, size_t b, const Eigen::Isometry3d& registered) const = 0;
  /** True if two poses of map \a b in one frame are the same place. */
  virtual bool isSame(size_t b, const Eigen::Isometry3d& T, const Eigen::Isometry3d& U) const = 0;
  /** True if two poses of map \a b in one frame are so near that they share their evidence. Of
   * poses at one place that do not, one may agree with the other maps and another may not. */
  virtual bool isNearlySame(size_t b, const Eigen::Isometry3d& T,
                            const Eigen::Isometry3d& U) const {
    return isSame(b, T, U);
  }
  /** True if maps a < b are sure that map \a b is there: by their match, by sure matches with two
   * other maps, or because they fit nowhere else nearly as well. The conflicts that they have at
   * this place are weighed already. */
  virtual bool isSure(size_t a, size_t b, const Eigen::Isometry3d& T_a_b) const = 0;
  /** Returns the pose of map \a b in the frame of map \a a that the match of maps a < b gives, if
   * the match is sure. A configuration that contradicts it is less probable. */
  virtual std::optional<Eigen::Isometry3d> sureMatch(size_t a, size_t b) const = 0;
  /** Bounding box of a map in its frame, m. Maps whose boxes do not meet have no evidence. */
  virtual Eigen::AlignedBox3d box(size_t map) const = 0;
  /** Area of each obstacle in the evidence of a map, m^2. */
  virtual double areaOfObstacle(size_t map) const = 0;
  /** Area of all surfaces of a map, m^2: that of all obstacles in its evidence. */
  virtual double areaOf(size_t map) const = 0;
  /** Shares of conflicts at which confirmed obstacles of a map count nothing. */
  virtual ConflictTolerance tolerance(size_t map) const = 0;
};

/** A map at a pose. */
struct Placement {
  size_t map;
  Eigen::Isometry3d T;
};

/** Poses of the maps of a team in one frame. */
struct Configuration {
  std::vector<std::optional<Eigen::Isometry3d>> pose;  ///< Pose of each map, if it is placed
  double score = 0;                                    ///< See scoreOf()
};

}  // namespace mrpt::fusion
