// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <utility>
#include <vector>

#include "fusion_team/graph/team_graph.h"

/** \file
 * The score of a configuration, updated where a map is placed or taken out. */

namespace mrpt::fusion {

/** How often each obstacle of a map is in one of some sets, at most kMost times. A bit plane holds
 * one binary digit of all counts. */
class ObstacleCounts {
 public:
  static constexpr size_t kDigits = 4;
  static constexpr unsigned kMost = (1U << kDigits) - 1;

  /** Adds 1 to the counts of the obstacles in a set. */
  void add(const ObstacleSet& set);
  /** Returns the count of obstacle \a i. */
  unsigned operator[](size_t i) const;

 private:
  std::array<ObstacleSet, kDigits> digit_;  // the lowest first
};

/** Obstacles of a map, compared with all other placed maps. */
struct KnownObstacles : ComparedObstacles {
  ObstacleSet explained;  ///< Obstacles in the free space of a map with a sure match
  ObstacleSet denied;     ///< Obstacles that sure matches confirm with maps that lie elsewhere
  /** Number of maps that say so. */
  ObstacleCounts times_confirmed, times_displaced, times_contradicted;
};

/** Numbers of conflicting obstacles, each by the share of its maps that see the conflict. */
struct ConflictShares {
  double displaced = 0, contradicted = 0;
};
/** Returns the conflicts of a map's obstacles. An obstacle that one map confirms and that lies in
 * the free space of another map is half a conflict: else each map that sees it would add a risk of
 * a conflict, but only the first map would add to the confirmed obstacles, and a right team would
 * lose by its size. */
ConflictShares conflictShares(const KnownObstacles& known);

/** What the evidence of two placed maps stands for. */
enum class Standing {
  Unsure,  ///< Evidence where the maps lie
  Sure,    ///< Evidence where the maps lie, at a sure pose: it explains the conflicts
  Parted   ///< Evidence at the pose of a sure match, from which the maps lie apart
};

/** What two placed maps say about each other, seen from one of them. */
struct Relation {
  const PairEvidence* evidence;  ///< Evidence of the pair
  bool is_a;                     ///< True if this map is map A of the evidence
  Standing standing;             ///< What the evidence stands for

  /** Obstacles of this map. */
  const ComparedObstacles& own() const { return is_a ? evidence->of_a : evidence->of_b; }
  /** Obstacles of the other map. */
  const ComparedObstacles& others() const { return is_a ? evidence->of_b : evidence->of_a; }
  Relation inverse() const { return {evidence, !is_a, standing}; }
};

/** Adds to the known obstacles of a map what another map says about them. */
void unite(KnownObstacles& all, const ComparedObstacles& more, Standing standing);

/** A configuration with its score. Only the maps that meet a map, or have a sure match with it,
 * change when it is placed. The evidence must outlive it. */
class ScoredTeam {
 public:
  ScoredTeam(const Configuration& configuration, const TeamEvidence& evidence);

  const TeamEvidence& evidence() const { return *evidence_; }
  /** Returns the poses with their score: the confirmed area of all placed maps, less the displaced,
   * the contradicted and the explained area, each over its TeamEvidence::tolerance(), less the
   * denied area. Displaced and contradicted obstacles count by conflictShares(). Where a
   * configuration parts the maps of a sure match, the match is lost evidence: that each of both
   * maps is confirmed by other maps does not make up for it. */
  Configuration configuration() const { return {pose_, score()}; }
  double score() const;
  /** Returns the area of the obstacles of all maps that parted sure matches confirm. */
  double deniedArea() const;
  bool isPlaced(size_t map) const { return pose_[map].has_value(); }
  const std::optional<Eigen::Isometry3d>& pose(size_t map) const { return pose_[map]; }

  /** Places a map that is not placed. Cost: O(n) boxes and sure matches, and the evidence of the
   * maps that meet. */
  void place(size_t map, const Eigen::Isometry3d& T);
  /** Takes a placed map out. Cost: the maps that meet it, each with the maps that meet it. */
  void remove(size_t map);

  /** Returns the bounding box of a map at a pose, in the frame of the configuration. */
  Eigen::AlignedBox3d boxAt(size_t map, const Eigen::Isometry3d& T) const {
    return evidence_->box(map).transformed(T);
  }
  /** Returns the bounding box of a placed map. */
  const Eigen::AlignedBox3d& box(size_t map) const { return box_[map]; }
  /** Returns the placed maps whose boxes meet a box. */
  std::vector<size_t> mapsAt(const Eigen::AlignedBox3d& box) const;

  /** Returns what a map at a pose and a placed map say about each other, seen from the first. */
  Relation relation(size_t map, const Eigen::Isometry3d& T, size_t placed) const;
  /** Returns what a map and a placed map say about each other at the pose of their sure match, seen
   * from the first, if the pose of the map parts it. The maps need not meet. */
  std::optional<Relation> partedRelation(size_t map, const Eigen::Isometry3d& T,
                                         size_t placed) const;
  /** Returns all parted relations of a map with its placed maps. Cost: O(n). */
  std::vector<std::pair<size_t, Relation>> partedRelations(size_t map,
                                                           const Eigen::Isometry3d& T) const;
  /** Returns the placed maps that say something about a placed map, in the order of placement. */
  const std::vector<std::pair<size_t, Relation>>& relations(size_t map) const {
    return relations_[map];
  }
  /** Returns the placed maps whose score a placed map changes. */
  std::vector<size_t> concernedBy(size_t map) const;
  /** Returns the area of a placed map that no other map confirms yet. */
  double openArea(size_t map) const;
  /** Returns the increase of a placed map's score by what another map says about it. */
  double gainOf(size_t placed, const ComparedObstacles& more, Standing standing) const;
  /** Returns the score of a map with some known obstacles. */
  double scoreOf(const KnownObstacles& known, size_t map) const;
  const KnownObstacles& known(size_t map) const { return known_[map]; }

 private:
  /** Returns the pose of the later of two maps in the frame of the earlier map. */
  Eigen::Isometry3d poseOfB(size_t map, const Eigen::Isometry3d& T, size_t placed) const;

  const TeamEvidence* evidence_;
  std::vector<std::optional<Eigen::Isometry3d>> pose_;
  std::vector<Eigen::AlignedBox3d> box_;
  std::vector<std::vector<std::pair<size_t, Relation>>> relations_;  // of maps that meet
  std::vector<std::vector<std::pair<size_t, Relation>>> parted_;     // of maps that lie apart
  std::vector<KnownObstacles> known_;
};

/** A map that may be placed at a pose, and what the placed maps say about it. It asks for the
 * evidence of the placed maps one after another, and only while its gain may still exceed a bound:
 * a map that one placed map contradicts need not be compared with all others. */
class Addition {
 public:
  /** \param[in] map,T The map and its pose.
   * \param[in] team The placed maps.
   * \param[in] least A smaller gain is of no interest. */
  Addition(size_t map, const Eigen::Isometry3d& T, const ScoredTeam& team, double least = 0);

  size_t map() const { return map_; }
  const Eigen::Isometry3d& pose() const { return T_; }
  const Eigen::AlignedBox3d& box() const { return box_; }

  /** Returns the increase of the team's score by the map. A gain of at most \a least is not exact,
   * but not above \a least. */
  double gain(const ScoredTeam& team);
  /** Returns an upper bound of the gain: all that may be confirmed. */
  double mostGain(const ScoredTeam& team) const { return gain_ + openArea(team); }
  /** Tells that the team has placed one more map.
   * \param[in] placed The map. \param[in] changed True for the maps that meet it. */
  void update(const ScoredTeam& team, size_t placed, const std::vector<bool>& changed);

 private:
  double openArea(const ScoredTeam& team) const;
  void add(size_t placed, const Relation& r);

  size_t map_;
  Eigen::Isometry3d T_;
  double least_;
  Eigen::AlignedBox3d box_;
  std::vector<size_t> open_;                        // maps to ask, the next one is the last
  std::vector<std::pair<size_t, Relation>> asked_;  // maps that say something
  KnownObstacles known_;
  double gain_ = 0;
  bool is_current_ = false;  // gain_ is that of the team as it is
};

}  // namespace mrpt::fusion
