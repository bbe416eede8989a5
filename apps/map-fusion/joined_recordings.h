// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "run_context.h"

/** \file
 * The key frames of several recordings as one recording. */

namespace map_fusion {

/** True if the result of a run is a recording, not a map: the output ends in `.simplemap`. */
bool writesRecording(const Arguments& args);

/** Checks that all inputs are simplemaps, if the result is a recording.
 * \exception std::runtime_error "<path>: <reason>". */
void checkRecordings(const RunContext& run);

/** Writes the key frames of all maps that have joined, in the frame of the first map. A map whose
 * observations another map has, too, adds no key frames. */
void joinRecordings(RunContext& run);

}  // namespace map_fusion
