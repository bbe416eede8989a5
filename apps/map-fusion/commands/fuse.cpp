// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion fuse` for two maps. */

#include "commands/commands.h"
#include "map_pair.h"
#include "poses_out.h"

namespace map_fusion {

bool runFuse(RunContext& run) {
  if (run.args.maps.size() != 2) return runFuseTeam(run);
  static MapPair pair;  // not freed at the end: main() leaves that to the system
  pair = loadPair(run);
  const bool accepted = matchPair(run, pair);
  if (accepted || run.args.force)
    mergePair(run, pair);
  else
    tellRejection(run, "; nothing was merged (--force merges)");
  savePoses(run, pair.fused != nullptr);
  drawPair(run, pair);
  return accepted;
}

}  // namespace map_fusion
