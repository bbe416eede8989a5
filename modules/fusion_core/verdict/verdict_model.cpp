// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * From evidence to probability. */
#include <mrpt/fusion/evaluation.h>

#include <algorithm>
#include <cmath>

namespace mrpt::fusion {

double VerdictModel::probability(double overlap, double conflicts, double rival,
                                 double inliers) const {
  const double log_odds = constant + log_overlap * std::log(std::max(overlap, min_overlap)) +
                          conflict_ratio * conflicts + runner_up * rival + inlier_ratio * inliers;
  return 1 / (1 + std::exp(-log_odds));
}

}  // namespace mrpt::fusion
