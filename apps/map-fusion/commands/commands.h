// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "run_context.h"

/** \file
 * The subcommands. */

namespace map_fusion {

/** A subcommand. \return False if a match is rejected, otherwise true. \exception std::exception
 * With one line that says where and why the command failed. */
using Command = bool (*)(RunContext& run);

bool runFuse(RunContext& run);       ///< Matches, judges and merges two maps, or the maps of a team
bool runFuseTeam(RunContext& run);   ///< Fuses the maps of several robots
bool runMatch(RunContext& run);      ///< Estimates the pose of B in A and judges it
bool runEvaluate(RunContext& run);   ///< Judges a given pose of B in A
bool runMerge(RunContext& run);      ///< Merges two maps at a given pose
bool runEdges(RunContext& run);      ///< Extracts structural edges
bool runTransform(RunContext& run);  ///< Moves a map to another frame
bool runSlice(RunContext& run);      ///< Writes a map as a 2-D grid for navigation
bool runBuild(RunContext& run);      ///< Builds a map from a recording
bool runPack(RunContext& run);       ///< Writes the maps of several robots to a rawlog
bool runInfo(RunContext& run);       ///< Reports the contents of a map
bool runJoin(RunContext& run);       ///< Exchanges and fuses maps with other robots over a link
bool runView(RunContext& run);       ///< Shows a map or a page in the browser

}  // namespace map_fusion
