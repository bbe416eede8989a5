// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/match_result.h>

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

/** \file
 * What two maps of a team say for and against a pose. */

namespace mrpt::fusion {

/** A set of the obstacles of a map, one bit each. */
using ObstacleSet = std::vector<uint64_t>;
/** Returns the number of obstacles in a set. */
double countOf(const ObstacleSet& set);

/** Obstacles of one map of a pair, compared with the other map. */
struct ComparedObstacles {
  ObstacleSet confirmed;     ///< Obstacles that the other map confirms
  ObstacleSet displaced;     ///< Obstacles in the other map's free space, near its obstacles
  ObstacleSet contradicted;  ///< Obstacles in the other map's free space, away from its obstacles
};

/** Evidence of a pair of maps at a pose. */
struct PairEvidence {
  Eigen::Isometry3d T_a_b;  ///< Pose of map B in A's frame, refined by at most some voxels
  ComparedObstacles of_a;   ///< Obstacles of A; empty sets if the maps do not meet
  ComparedObstacles of_b;   ///< Obstacles of B; empty sets if the maps do not meet
  /** Where the registration places B; none if that is another place, if few obstacles are
   * confirmed, or if the maps contradict each other. */
  std::optional<Eigen::Isometry3d> registered = std::nullopt;

  /** Returns the number of obstacles of both maps in one of their sets. */
  double count(ObstacleSet ComparedObstacles::*set) const {
    return countOf(of_a.*set) + countOf(of_b.*set);
  }
  double confirmed() const { return count(&ComparedObstacles::confirmed); }
  double displaced() const { return count(&ComparedObstacles::displaced); }
  double contradicted() const { return count(&ComparedObstacles::contradicted); }
};

/** Largest motion of a pose to the refined pose, and largest difference of two poses that share
 * their evidence, share of the tolerance of a right pose. With more, each pair of a pile of maps
 * would find a pose of its own. */
constexpr double kSharedEvidence = 0.2;

/** The evidence of a pair of maps at any pose. It remembers the poses that it was asked for.
 * Several threads may use it. */
class EvidenceOfPair {
 public:
  /** \param[in] a,b The maps A and B, both whole maps.
   * \param[in] options Parameters of all stages. */
  EvidenceOfPair(const PreparedMap& a, const PreparedMap& b, const Options& options);
  ~EvidenceOfPair();

  /** Returns the evidence near a pose. The pose is first refined by some voxels. If the
   * refined pose is farther away than a fifth of the tolerance of a right pose, the evidence is
   * that of the given pose. Poses at one place share the refined pose. Cost: some milliseconds for
   * the first pose at a place, half a millisecond for further poses; microseconds where the maps do
   * not meet or the evidence is known. */
  const PairEvidence& near(const Eigen::Isometry3d& T_a_b);
  /** Returns the covariance of a registered pose, see PairEvidence::registered and
   * MatchResult::covariance. Cost: some milliseconds for the first question. */
  Matrix6d covarianceAt(const Eigen::Isometry3d& registered);
  /** Starts anew, as if no pose had been asked for: which evidence answers a question depends on
   * the questions before. The evidence of a pose that was asked for since the last restart is not
   * computed again. No reference of near() is valid afterwards. */
  void restart();
  /** True if two poses of B differ by at most the tolerance of a right pose, times \a factor. */
  bool isSame(const Eigen::Isometry3d& T, const Eigen::Isometry3d& U, double factor = 1) const;

 private:
  struct Comparison;
  struct Known {
    Eigen::Vector3d middle;  // middle of B at the pose of the evidence, m
    PairEvidence evidence;
  };
  /** Values of a function of a pose. Those from before the last restart are not made again. */
  template <class Value>
  class Memo {
   public:
    template <class Make>
    const Value& at(const Eigen::Isometry3d& T, const Make& make);
    void restart() { before_ = std::exchange(values_, {}); }

   private:
    using Key = std::array<double, 16>;
    std::map<Key, Value> values_, before_;
  };
  struct Hash {
    size_t operator()(const Eigen::Vector3i& cell) const;
  };
  /** Indices of the known evidence that may answer, by the cell of the middle of B. */
  using Index = std::unordered_map<Eigen::Vector3i, std::vector<size_t>, Hash>;
  Eigen::Vector3i cellOf(const Eigen::Vector3d& middle) const;
  void remember(Known known);
  bool mayMeet(const Eigen::Isometry3d& T_a_b) const;
  bool answers(const Known& known, const Eigen::Isometry3d& T_a_b) const;
  const PairEvidence& at(const Eigen::Isometry3d& T_a_b);
  std::optional<Eigen::Isometry3d> registeredNear(const Eigen::Isometry3d& T_a_b);
  Known computed(const Eigen::Isometry3d& T_a_b);

  PreparedMap a_, b_;
  Options options_;
  Eigen::AlignedBox3d box_a_, box_b_;
  Eigen::Vector3d middle_b_;
  std::unique_ptr<Comparison> comparison_;
  std::deque<Known> known_;
  Index known_in_;
  std::vector<Eigen::Isometry3d> registered_;  // one for each place
  Memo<PairEvidence> compared_;                // evidence without a refinement
  Memo<Eigen::Isometry3d> refined_;            // by the start of the refinement
  Memo<Matrix6d> covariance_;                  // by the registered pose
  std::mutex mutex_;
};

}  // namespace mrpt::fusion
