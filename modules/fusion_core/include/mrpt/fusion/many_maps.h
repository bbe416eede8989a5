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
 * One map of many (not in the paper, which fuses two). */

namespace mrpt::fusion {

/** One robot's map. */
struct RobotMap {
  std::string robot;  ///< Name of the robot
  PreparedMap map;    ///< Its map, prepared with the features of the options
  /** Pose of the map's frame in a common frame; noGuess(): nothing is known. */
  mrpt::poses::CPose3DPDFGaussian pose = noGuess();
};

/** What became of one robot's map. */
struct FusionMember {
  std::string robot;                     ///< Name of the robot
  bool joined = false;                   ///< True if it is part of the fused map
  mrpt::poses::CPose3DPDFGaussian pose;  ///< Pose of its frame in the fused map's, as far as known
  std::string matched_with;  ///< Robot whose map is A of the alignment; empty for the first map
  Alignment alignment;       ///< Its best match; the pose is in the frame of \a matched_with

  /** True unless this is the first map, whose frame is kept: the others are matched. */
  bool hasMatch() const { return alignment.voxels_b > 0; }
};

/** The map of many, and what became of each. */
struct ManyFused {
  std::unique_ptr<octomap::OcTree> map;  ///< In the frame of the first robot's map
  std::vector<FusionMember> members;     ///< In the order of the maps given
};

/** Called before each match: the robot, and how many maps have joined so far. */
using OnMember = std::function<void(const std::string& robot, size_t joined)>;

/** Fuses the maps of several robots: the first whole map grows by the others. Each map that is left
 * is matched with each map that has joined, from the poses that they bring, and the accepted match
 * with the highest probability joins: a robot that shares nothing with the first may meet it
 * through a third. No pair is matched twice, and no map is prepared again. Maps that are edges
 * alone are matched last, for their poses. \param[in] maps One map of each robot. \param[in]
 * options Of all steps. \param[in] even_rejected Let the most probable match join although it is
 * rejected. \param[in] on_member Called before each match. \param[in] on_iteration See align().
 * \exception std::exception If there is no whole map, or a map has no occupied voxel: "<robot>:
 * <reason>". Cost: at most n (n-1) / 2 matches for n maps. */
MRPT_FUSION_API ManyFused fuseMaps(const std::vector<RobotMap>& maps, const Options& options,
                                   bool even_rejected = false, const OnMember& on_member = {},
                                   const OnIteration& on_iteration = {});

}  // namespace mrpt::fusion
