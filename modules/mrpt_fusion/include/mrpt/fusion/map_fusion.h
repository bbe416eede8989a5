// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/fusion/many_maps.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>

#include <vector>

/** \file
 * Fuses the maps that several robots have sent. */

namespace mrpt::fusion {

/** The fused map, and the result for each robot. */
struct MRPT_FUSION_API FusionResult {
  mrpt::maps::CProbOctoMap map;       ///< Fused map, in the frame of the first robot's map
  std::vector<FusionMember> members;  ///< Results, in the order of the maps

  /** Returns whether all maps have joined, except those that are edges alone. */
  bool isComplete() const;
};

/** Fuses the maps that several robots have sent, see mrpt::fusion::fuseMaps().
 * \param[in] matching Its options and its onIteration are used. \param[in] maps The latest map of
 * each robot. \param[in] even_rejected Whether the most probable match joins even if it is
 * rejected. \param[in] on_member Called before each match. \exception std::exception If all maps
 * are edges alone, or "<robot>: <reason>" if a map has no occupied voxel or is of another kind. */
MRPT_FUSION_API FusionResult fuseMaps(const mrpt::slam::CProbabilisticMapMatching& matching,
                                      const std::vector<mrpt::obs::CObservationLocalMap::Ptr>& maps,
                                      bool even_rejected = false, const OnMember& on_member = {});

}  // namespace mrpt::fusion
