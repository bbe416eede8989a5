// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>

#include <functional>
#include <string>
#include <vector>

/** \file
 * One map of many. */

namespace mrpt::slam {

/** What became of one robot's map. */
struct FusionMember {
  std::string robot;                     ///< its name, see CObservationLocalMap
  bool joined = false;                   ///< it is part of the fused map
  mrpt::poses::CPose3DPDFGaussian pose;  ///< of its frame in the fused map's; as far as known
  CProbabilisticMapMatching::TReturnInfo info;  ///< of its last match

  /** The first map is not matched: the others are, with it. */
  bool hasMatch() const { return info.voxels_m2 > 0; }
};

/** The map of many, and what became of each. */
struct FusionResult {
  mrpt::maps::CProbOctoMap map;       ///< in the frame of the first robot's map
  std::vector<FusionMember> members;  ///< in the order of the maps given

  /** Whether all joined, but those that are edges alone. */
  bool isComplete() const;
};

/** Told before each match: the robot, how many maps have joined so far. */
using OnMember = std::function<void(const std::string& robot, size_t joined)>;

/** Fuses the maps of several robots (not in the paper, which fuses two): the first one that is not
 * edges alone grows by the others. Each time all that are left are matched with what has joined so
 * far, from the poses that they bring, and the accepted match with the highest probability joins:
 * a robot that shares nothing with the first may meet it through a third. Those that are edges
 * alone are matched last, for their poses.
 *
 * Two maps' poses tell nothing of each other if either's standard deviations are a kilometre.
 * \param[in,out] matching Its options and callbacks are used. \param[in] maps The last of each
 * robot. \param[in] even_rejected Let the most probable match join although it is rejected.
 * \param[in] on_member Called before each match. \exception std::exception If there is no map but
 * edges, or one has no occupied voxel, or is of another kind: "<robot>: <reason>". Cost: up to n
 * (n-1) / 2 matches for n maps. */
FusionResult fuseMaps(CProbabilisticMapMatching& matching,
                      const std::vector<mrpt::obs::CObservationLocalMap::Ptr>& maps,
                      bool even_rejected = false, const OnMember& on_member = {});

}  // namespace mrpt::slam
