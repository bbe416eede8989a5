// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion evaluate`. */

#include <mrpt/fusion/alignment.h>

#include "commands/commands.h"
#include "map_pair.h"

namespace map_fusion {

bool runEvaluate(RunContext& run) {
  MapPair pair = loadPair(run);
  preparePair(run, pair);
  const auto& [a, b] = *pair.prepared;
  run.report.match = mrpt::fusion::evaluate(a, b, run.report.pose->mean, run.options);
  run.report.pose->cov = run.report.match->pose().cov;
  run.endStep("evaluate");
  drawPair(run, pair);
  return concludeMatch(run);
}

}  // namespace map_fusion
