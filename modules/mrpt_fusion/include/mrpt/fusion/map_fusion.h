// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/fusion/many_maps.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>

#include <vector>

/** \file
 * One map of many. */

namespace mrpt::fusion {

/** The map of many, and what became of each. */
struct MRPT_FUSION_API FusionResult {
  mrpt::maps::CProbOctoMap map;       ///< in the frame of the first robot's map
  std::vector<FusionMember> members;  ///< in the order of the maps given

  /** Whether all joined, but those that are edges alone. */
  bool isComplete() const;
};

/** Fuses the maps that several robots have sent, see mrpt::fusion::fuseMaps().
 * \param[in] matching Its options and onIteration are used. \param[in] maps The last of each
 * robot. \param[in] even_rejected Let the most probable match join although it is rejected.
 * \param[in] on_member Called before each match. \exception std::exception If there is no map but
 * edges, or one has no occupied voxel, or is of another kind: "<robot>: <reason>". */
MRPT_FUSION_API FusionResult fuseMaps(const mrpt::slam::CProbabilisticMapMatching& matching,
                                      const std::vector<mrpt::obs::CObservationLocalMap::Ptr>& maps,
                                      bool even_rejected = false, const OnMember& on_member = {});

}  // namespace mrpt::fusion
