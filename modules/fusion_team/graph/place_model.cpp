// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * From the evidence for a place to its probability. */
#include "fusion_team/graph/place_model.h"

#include <algorithm>
#include <cmath>

namespace mrpt::fusion {

double PlaceModel::probability(double runner_up_ratio, double overlap) const {
  const double log_odds = constant + runner_up * std::min(runner_up_ratio, 1.0) +
                          log_overlap * std::log(std::max(overlap, min_overlap));
  return 1 / (1 + std::exp(-log_odds));
}

double PlaceModel::ofAnotherPose(const std::optional<double>& preferred) const {
  return preferred ? std::min(*preferred, 1 - *preferred) : without_place;
}

}  // namespace mrpt::fusion
