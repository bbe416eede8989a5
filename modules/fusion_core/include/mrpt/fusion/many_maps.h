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

/** The fused map, and the result for each robot's map. */
struct ManyFused {
  std::unique_ptr<octomap::OcTree> map;  ///< Fused map, in the frame of the first whole map
  std::vector<FusionMember> members;     ///< Result of each map, in the order of the input
};

/** Called before each match with the robot and the number of maps that have joined. */
using OnMember = std::function<void(const std::string& robot, size_t joined)>;

/** Fuses the maps of several robots. The first whole map grows by the other maps.
 *
 * In each round, every map that has not joined is matched with every map that has joined. The
 * matches start from the poses of the maps. The map with the most probable accepted match joins.
 * So a map without overlap with the first map can join through a third map. No pair is matched
 * twice, and no map is prepared again. Maps that have only edges are matched last, for their poses.
 * Cost: at most n (n-1) / 2 matches for n maps.
 * \param[in] maps One map of each robot.
 * \param[in] options Parameters of all stages.
 * \param[in] even_rejected If true, the map with the most probable match joins even if rejected.
 * \param[in] on_member Called before each match.
 * \param[in] on_iteration See align().
 * \exception std::exception If there is no whole map, or a map has no occupied voxel: "<robot>:
 * <reason>". */
MRPT_FUSION_API ManyFused fuseMaps(const std::vector<RobotMap>& maps, const Options& options,
                                   bool even_rejected = false, const OnMember& on_member = {},
                                   const OnIteration& on_iteration = {});

}  // namespace mrpt::fusion
