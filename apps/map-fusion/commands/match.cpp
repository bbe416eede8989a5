// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion match`. */

#include "commands/commands.h"
#include "map_pair.h"

namespace map_fusion {

bool runMatch(RunContext& run) {
  MapPair pair = loadPair(run);
  matchPair(run, pair);
  drawPair(run, pair);
  return concludeMatch(run);
}

}  // namespace map_fusion
