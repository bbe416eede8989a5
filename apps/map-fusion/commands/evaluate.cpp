// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion evaluate`. */

#include <mrpt/fusion/alignment.h>

#include "commands/commands.h"
#include "map_pair.h"

namespace map_fusion {

bool runEvaluate(RunContext& run) {
  const MapPair pair = loadPair(run);
  run.report.match =
      mrpt::fusion::evaluate(pair.a.view(), pair.b.view(), run.report.pose->mean, run.options);
  run.report.pose = run.report.match->pose;
  run.endStep("evaluate");
  drawPair(run, pair);
  return run.report.match->evaluation.accepted;
}

}  // namespace map_fusion
