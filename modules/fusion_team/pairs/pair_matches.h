// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>

#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "fusion_team/graph/team_graph.h"
#include "fusion_team/pairs/candidates.h"
#include "fusion_team/pairs/executor.h"
#include "fusion_team/pairs/pair_memory.h"

/** \file
 * The matches of the pairs of a team, and the evidence of all pairs. */

namespace mrpt::fusion {

/** The match of two maps of a team. */
struct PairMatch {
  size_t a;             ///< Index of map A
  size_t b;             ///< Index of map B; larger than a
  Alignment alignment;  ///< The match, with all its hypotheses
};

/** Returns the hypotheses of a match that may be part of a configuration, the match first. */
std::vector<Eigen::Isometry3d> hypothesesOf(const PairMatch& match);

/** Matches pairs of whole maps. Each match is independent of the others. Matches that \a memory
 * knows cost nothing. */
std::vector<PairMatch> matchPairs(const std::vector<RobotMap>& maps,
                                  const std::vector<CandidatePair>& pairs, const Options& options,
                                  Executor& executor, const OnMember& on_member,
                                  PairMemory& memory);
/** Matches the candidatePairs() of whole maps. */
std::vector<PairMatch> matchPairs(const std::vector<RobotMap>& maps, const Options& options,
                                  Executor& executor, const OnMember& on_member,
                                  PairMemory& memory);

/** The evidence of a team of whole maps. It refers to the maps, which must outlive it. */
class EvidenceOfMaps : public TeamEvidence {
 public:
  EvidenceOfMaps(const std::vector<RobotMap>& maps, const Options& options, PairMemory& memory);

  size_t size() const override { return maps_.size(); }
  const PairEvidence& near(size_t a, size_t b, const Eigen::Isometry3d& T_a_b) const override;
  Matrix6d covariance(size_t a, size_t b, const Eigen::Isometry3d& registered) const override;
  bool isSame(size_t b, const Eigen::Isometry3d& T, const Eigen::Isometry3d& U) const override;
  bool isNearlySame(size_t b, const Eigen::Isometry3d& T,
                    const Eigen::Isometry3d& U) const override;
  bool isSure(size_t a, size_t b, const Eigen::Isometry3d& T_a_b) const override;
  std::optional<Eigen::Isometry3d> sureMatch(size_t a, size_t b) const override;
  Eigen::AlignedBox3d box(size_t map) const override { return box_[map]; }
  double areaOfObstacle(size_t map) const override { return area_of_obstacle_[map]; }
  double areaOf(size_t map) const override { return area_[map]; }
  ConflictTolerance tolerance(size_t map) const override { return conflict_tolerance_[map]; }
  /** True if a match is accepted and the maps bear it out: they overlap there, and they fit better
   * at none of its other hypotheses. What a match claims counts only then: a wrong match may claim
   * to be sure. */
  bool holds(const PairMatch& match) const;
  /** Sets the tolerance of each place to a multiple of the shares of conflicts of its maps, at the
   * clear poses of their pairs. A pose is clear if it has the overlap of an accepted match, at
   * most EvaluationParams::max_free_conflict conflicts (each with weight 1), and no other
   * hypothesis of the pair fits half as well; what the matches claim does not count. Maps that
   * clear poses connect are one place. The tolerance of a place where nothing moves is the least; a
   * fixed share is the largest. People who walk are obstacles in one map and free space in another.
   */
  void adaptTolerance(const std::vector<PairMatch>& matches);
  /** Sets the sure poses, see isSure(): those of sure matches, those on which most sure matches
   * with other maps agree (see mostAgreed()), and the clear poses of other pairs. A match is sure
   * if it holds(), and has at least a probability or a clear pose. Cost: O(n^2), and for each map
   * the square of the number of its sure matches. */
  void setSureMatches(const std::vector<PairMatch>& matches, double least_probability);

 private:
  /** A pose of which two maps are sure. */
  struct SurePose {
    Eigen::Isometry3d T_a_b;
    bool is_match;  // the match of the maps is sure, see sureMatch()
  };
  /** How well a pair fits: confirmed obstacles less conflicts over kMostTolerance. */
  double fit(const PairEvidence& e) const;
  /** Share of the surface of both maps that is confirmed. */
  double overlapOf(size_t a, size_t b, const PairEvidence& e) const;
  /** Best fit of another hypothesis of a match over the fit of a pose. Infinity if the pose has
   * less overlap than an accepted match. */
  double rivalOf(const PairMatch& match, const Eigen::Isometry3d& T_a_b) const;
  /** True if a pose of the maps of a match is clear, see adaptTolerance(). */
  bool isClear(const PairMatch& match, const Eigen::Isometry3d& T_a_b) const;
  /** Poses of maps b in the frames of maps a < b that the sure matches of both with other maps
   * give. */
  std::map<std::pair<size_t, size_t>, std::vector<Eigen::Isometry3d>> posesByOthers() const;
  /** The pose of map \a b on which most poses agree, at least two. Nothing if as many agree on
   * another place. */
  std::optional<Eigen::Isometry3d> mostAgreed(size_t b,
                                              const std::vector<Eigen::Isometry3d>& poses) const;
  /** Pose of the maps of a match without a strong rival, if there is one. */
  std::optional<Eigen::Isometry3d> clearPoseOf(const PairMatch& match) const;
  /** Where nothing moves, a right configuration has less than half of these shares of conflicts,
   * see doc/decisions/037-team.md. */
  static constexpr ConflictTolerance kLeastTolerance{0.03, 0.01};
  /** The verdict on a pair refuses half of this share of conflicts. */
  static constexpr double kMostTolerance = 0.2;
  /** Largest fit of the best rival of a clear pose: a wrong pose has a stronger rival. */
  static constexpr double kMostRivalOfClear = 0.5;
  const std::vector<RobotMap>& maps_;
  std::vector<double> area_, area_of_obstacle_;
  std::vector<Eigen::AlignedBox3d> box_;
  std::vector<std::vector<std::shared_ptr<EvidenceOfPair>>> pairs_;  // by a and b - a - 1
  std::vector<std::vector<std::optional<SurePose>>> sure_;           // by a and b - a - 1
  std::vector<Eigen::Vector3d> middle_;
  PoseTolerance tolerance_;
  double min_overlap_;                                 // of a match that holds, and of a clear pose
  double max_conflict_;                                // share of conflicts of a clear pose
  std::vector<ConflictTolerance> conflict_tolerance_;  // by map
};

}  // namespace mrpt::fusion
