// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/export.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

/** \file
 * Fuses the maps of several robots (not in the paper, which fuses two maps). */

namespace mrpt::fusion {

/** One robot's map. */
struct RobotMap {
  std::string robot;  ///< Name of the robot
  PreparedMap map;    ///< Map of the robot, prepared with the features of the options
  /** Pose of the map's frame in a common frame; noGuess() if unknown. */
  mrpt::poses::CPose3DPDFGaussian pose = noGuess();
};

/** The result for one robot's map. */
struct FusionMember {
  std::string robot;                     ///< Name of the robot
  bool joined = false;                   ///< True if the map is part of the fused map
  mrpt::poses::CPose3DPDFGaussian pose;  ///< Pose in the frame of the fused map, if known
  std::string matched_with;  ///< Robot whose map is A of the alignment; empty for the first map
  Alignment alignment;       ///< Best match; the pose is in the frame of \a matched_with

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
  std::vector<TeamPair> pairs;           ///< Matches of all pairs of a team; empty for two maps
};

/** Called before each match with a robot and the number of maps that the robot is matched with,
 * this match included. Never called by two threads at a time. */
using OnMember = std::function<void(const std::string& robot, size_t joined)>;

/** Fuses the maps of several robots, in the frame of the first whole map.
 *
 * Two whole maps are matched by align(). More maps are a team: all pairs are matched, each from the
 * poses of the maps, and the poses are those at which all pairs agree best. A map joins if no other
 * place agrees nearly as well, and if a loop of matches confirms its place or a match is sure
 * without a loop, see doc/decisions/037-team.md. So a match that would be rejected alone can join,
 * and a match that would be accepted alone can be rejected. Maps that have only edges are matched
 * last, for their poses. Cost: n (n-1) / 2 matches for n maps, and a search of the poses.
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

}  // namespace mrpt::fusion
