// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "run_context.h"

/** \file
 * The file of `--poses-out`. */

namespace map_fusion {

/** Returns whether the extension of a path is a format of poses. */
bool isPosesFile(const std::string& path);

/** Writes the poses of all placed robots, if the arguments name a file. The extension decides the
 * format. \param[in] is_merged For two maps: true if both are merged.
 * \exception std::runtime_error "<path>: <reason>". */
void savePoses(RunContext& run, bool is_merged);

}  // namespace map_fusion
