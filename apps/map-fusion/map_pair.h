// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/prepared_map.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "mrpt_maps.h"
#include "run_context.h"

/** \file
 * The steps that several commands on two maps share. */

namespace map_fusion {

/** The maps of a run on two maps. */
struct MapPair {
  LoadedMap a, b;
  std::optional<mrpt::fusion::Prior> prior;      ///< Guess of a g2o file
  std::shared_ptr<const octomap::OcTree> fused;  ///< Null: nothing was merged
  std::optional<std::pair<mrpt::fusion::PreparedMap, mrpt::fusion::PreparedMap>>
      prepared;  ///< Both maps, prepared; nothing if they are merged at a given pose
};

/** Loads both maps. Parses the poses of the arguments before. */
MapPair loadPair(RunContext& run);

/** Prepares both maps in parallel. */
void preparePair(const RunContext& run, MapPair& pair);

/** Estimates the pose of B in A, and writes it if wanted. \return Whether it is accepted. */
bool matchPair(RunContext& run, MapPair& pair);

/** Says on stderr why the match is rejected. \param[in] consequence End of the line. */
void tellRejection(const RunContext& run, const std::string& consequence = {});

/** Ends a run that only matches: says why the match is rejected if no summary does so.
 * \return Whether the match is accepted. */
bool concludeMatch(const RunContext& run);

/** Merges both maps at the pose of the report, and saves the result. */
void mergePair(RunContext& run, MapPair& pair);

/** Draws the picture, the scene and the page if they are wanted. */
void drawPair(RunContext& run, const MapPair& pair);

/** Applies the merge policy of the arguments, and reports it. */
void choosePolicy(RunContext& run);

/** Notes if not all observations of a map count. \param[in] with Name of the map with the same
 * sources. */
void noteCounting(RunContext& run, const std::string& map, mrpt::fusion::Counting counting,
                  const std::string& with);

/** Saves a fused map with its sources, and reports on it. If the output is a recording, the joined
 * recordings are written instead of the map. */
void saveFused(RunContext& run, const std::shared_ptr<const octomap::OcTree>& fused,
               const mrpt::fusion::Sources& sources);

}  // namespace map_fusion
