// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/export.h>
#include <mrpt/fusion/merging.h>
#include <mrpt/fusion/sources.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

/** \file
 * Fuses the maps of several robots (not in the paper, which fuses two maps). */

namespace mrpt::fusion {

/** Knowledge of a map's pose in the frame of another robot's map. */
struct PoseGuess {
  std::string robot;  ///< Name of the other robot; its map is A
  Prior prior;        ///< Pose of the map in A's frame
};

/** One robot's map. */
struct RobotMap {
  std::string robot;  ///< Name of the robot
  PreparedMap map;    ///< Map of the robot, prepared with the features of the options
  /** Pose of the map's frame in a common frame; noGuess() if unknown. */
  mrpt::poses::CPose3DPDFGaussian pose = noGuess();
  /** Guesses for single pairs. The guess of a pair replaces what \a pose says of it. */
  std::vector<PoseGuess> guesses = {};
};

/** A match that holds a map in its place. */
struct FusionLink {
  size_t with =
      0;  ///< Index of the member whose map is A. Map B is that of the member with the link
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< Measured pose of map B in A's frame
  Matrix6d covariance = Matrix6d::Zero();                   ///< See MatchResult::covariance
};

/** The result for one robot's map. */
struct FusionMember {
  std::string robot;    ///< Name of the robot
  bool joined = false;  ///< True if the map is part of the fused map
  /** Pose in the frame of the fused map, if known. Of the joined maps of a team: the pose at which
   * all links agree best, with its joint covariance from all links. */
  mrpt::poses::CPose3DPDFGaussian pose;
  std::string matched_with;  ///< Robot whose map is A of the alignment; empty for the first map
  /** Best match; its pose is in the frame of \a matched_with. In a team, the verdict with its
   * probability is that of the team on \a pose. */
  Alignment alignment;
  Counting counting = Counting::All;  ///< How the map counts in the fused map, if it has joined
  std::string
      counted_with;  ///< Robot whose map has the same sources; empty if all observations count
  /** Robots whose maps fit this map, if they hold together but not with the first map. They can be
   * fused without the first map. */
  std::vector<std::string> fits;
  /** Matches that hold the map in its place, if it has joined. A match of two maps is a link of one
   * of both. The first link is \a alignment. */
  std::vector<FusionLink> links;

  /** True except for the first map. The first map keeps its frame; all other maps are matched. */
  bool hasMatch() const { return alignment.voxels_b > 0; }
};

/** The match of two maps of a team. */
struct TeamPair {
  std::string a;           ///< Robot whose map is A of the match
  std::string b;           ///< Robot whose map is B of the match
  bool accepted = false;   ///< True if the match would be accepted alone
  bool ambiguous = false;  ///< True if a rival is the only reason for the rejection
  double probability = 0;  ///< Probability that the pose of the match is right, [0,1]
  double overlap = 0;      ///< Overlap at the pose of the match, eq. (25), [0,1]
  bool holds = false;      ///< True if both maps lie at the pose of the match in the fused map
};

/** The fused map, and the result for each robot's map. */
struct ManyFused {
  std::unique_ptr<octomap::OcTree> map;  ///< Fused map, in the frame of the first whole map
  std::vector<FusionMember> members;     ///< Result of each map, in the order of the input
  Sources sources;                       ///< Sources of the maps that have joined
  std::vector<TeamPair> pairs;           ///< Matches of the pairs of a team; empty for two maps
};

/** Called before each match with a robot and the number of maps that the robot is matched with,
 * this match included. Never called by two threads at a time. */
using OnMember = std::function<void(const std::string& robot, size_t joined)>;

/** Fuses the maps of several robots, in the frame of the first whole map.
 *
 * Two whole maps are matched by align(). More maps are a team: all pairs are matched, each from the
 * poses of the maps (of more than 25 maps, 12 pairs for each map that look alike), and the poses
 * are those at which all pairs agree best. A map joins if no other place agrees nearly as well, and
 * if a loop of matches confirms its place or a match is sure without a loop, see
 * doc/decisions/037-team.md. So a match that would be rejected alone can join, and a match that
 * would be accepted alone can be rejected. Maps that have only edges are matched last, for their
 * poses. The first whole map keeps its frame; the order of the other maps does not change the
 * result. No observation counts twice, see Counting, unless options.merge.independent says so.
 * Cost: n (n-1) / 2 matches for n maps, at most 12 n, and a search of the poses.
 * \param[in] maps One map of each robot.
 * \param[in] options Parameters of all stages.
 * \param[in] even_rejected If true, maps that have not joined are matched with all joined maps,
 * and join by their most probable match.
 * \param[in] on_member Called before each match.
 * \param[in] on_iteration See align().
 * \exception std::exception If there is no whole map, or a map has no occupied voxel: "<robot>:
 * <reason>". */
MRPT_FUSION_API ManyFused fuseMaps(const std::vector<RobotMap>& maps, const Options& options,
                                   bool even_rejected = false, const OnMember& on_member = {},
                                   const OnIteration& on_iteration = {});

/** The fused map of a team, and the result for each robot. */
struct TeamState {
  std::shared_ptr<const octomap::OcTree> map;  ///< Fused map; null if the team has no map
  std::vector<FusionMember> members;           ///< Result of each map, in the order of the robots
  Sources sources;                             ///< Sources of the maps that have joined
  std::vector<TeamPair> pairs;                 ///< Matches of the pairs; empty for two maps
};

/** A team whose maps change: robots come, send newer maps, and go.
 *
 * The state is that of fuseMaps() with the present maps, bit for bit. The maps are in the order in
 * which their robots came; a newer map keeps the place of the older map. So the robot that came
 * first keeps its frame while it has a whole map in the team.
 *
 * Several threads may call all functions. A change does not wait for a fusion.
 *
 * Cost of a state: the matches of the maps that have changed with all other maps, the search of the
 * poses with the evidence of all other pairs remembered, and the blocks of the fused map that have
 * changed. */
class MRPT_FUSION_API MapTeam {
 public:
  /** \param[in] options Parameters of all stages. */
  explicit MapTeam(Options options = {});
  ~MapTeam();
  MapTeam(const MapTeam&) = delete;
  MapTeam& operator=(const MapTeam&) = delete;

  /** Adds the map of a robot, or replaces it. */
  void set(RobotMap map);
  /** Removes the map of a robot. \return False if the team has no such robot. */
  bool remove(const std::string& robot);
  /** Returns the names of the robots, in their order. */
  std::vector<std::string> robots() const;
  /** Returns the state of all maps that are in the team at the time of the call. Fuses if something
   * has changed. The state does not change afterwards.
   * \exception std::exception As fuseMaps(). */
  std::shared_ptr<const TeamState> state();

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

/** A map and its sources. */
struct SourcedMap {
  const octomap::OcTree& map;  ///< The map. Not owned
  Sources sources = {};        ///< Its sources; empty: the map is a source of its own
};

/** The result of mergeSources(). */
struct MergedSources {
  std::unique_ptr<octomap::OcTree> map;  ///< Fused map
  Counting of_a = Counting::All;         ///< How map A counts
  Counting of_b = Counting::All;         ///< How map B counts
  Sources sources;                       ///< Sources of both maps
};

/** Merges two maps so that no observation counts twice. Maps without a common source are merged by
 * mergeMaps(). If one map holds all sources of the other map, the result is this map, in A's frame.
 * \param[in] a,b The maps.
 * \param[in] T_a_b Pose of map B in A's frame.
 * \param[in] params The policy. If `independent` is set, both maps count.
 * \param[in] is_given True if the user gives the pose. Maps with the same voxels are one source
 * then only if the pose moves no point of B by half a voxel: at another pose both count.
 * \exception std::exception As mergeMaps(). */
MRPT_FUSION_API MergedSources mergeSources(const SourcedMap& a, const SourcedMap& b,
                                           const Eigen::Isometry3d& T_a_b,
                                           const MergeParams& params, bool is_given = false);

}  // namespace mrpt::fusion
