// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

/** \file
 * One map of many (not in the paper, which fuses two). */

namespace mrpt::fusion {

/** One robot's map. */
struct RobotMap {
  std::string robot;  ///< its name
  MapView map;        ///< not owned
  /** Of the map's frame in a common one. Standard deviations of a kilometre: nothing is known. */
  mrpt::poses::CPose3DPDFGaussian pose;
};

/** What became of one robot's map. */
struct FusionMember {
  std::string robot;                     ///< its name
  bool joined = false;                   ///< it is part of the fused map
  mrpt::poses::CPose3DPDFGaussian pose;  ///< of its frame in the fused map's; as far as known
  Alignment info;                        ///< its last match

  /** The first map is not matched: the others are, with it. */
  bool hasMatch() const { return info.voxels_m2 > 0; }
};

/** The map of many, and what became of each. */
struct ManyFused {
  std::unique_ptr<octomap::OcTree> map;  ///< in the frame of the first robot's map
  std::vector<FusionMember> members;     ///< in the order of the maps given
};

/** Told before each match: the robot, how many maps have joined so far. */
using OnMember = std::function<void(const std::string& robot, size_t joined)>;

/** Fuses the maps of several robots: the first one that is not edges alone grows by the others.
 * Each time all that are left are matched with what has joined so far, from the poses that they
 * bring, and the accepted match with the highest probability joins: a robot that shares nothing
 * with the first may meet it through a third. Those that are edges alone are matched last, for
 * their poses.
 * \param[in] maps Of each robot one. \param[in] options Of all steps. \param[in] even_rejected Let
 * the most probable match join although it is rejected. \param[in] on_member Called before each
 * match. \param[in] on_iteration See align(). \exception std::exception If there is no map but
 * edges, or one has no occupied voxel: "<robot>: <reason>". Cost: up to n (n-1) / 2 matches for n
 * maps. */
ManyFused fuseMaps(const std::vector<RobotMap>& maps, const Options& options,
                   bool even_rejected = false, const OnMember& on_member = {},
                   const OnIteration& on_iteration = {});

}  // namespace mrpt::fusion
