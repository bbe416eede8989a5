// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion merge`. */

#include "commands/commands.h"
#include "map_pair.h"

namespace map_fusion {

bool runMerge(RunContext& run) {
  MapPair pair = loadPair(run);
  mergePair(run, pair);
  drawPair(run, pair);
  return true;
}

}  // namespace map_fusion
