// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

/** \file
 * The probability that a map of a team is placed right. */

namespace mrpt::fusion {

/** Logistic regression from the evidence for the place of a map to the probability that the place
 * is right, within PoseTolerance. It is fitted by scripts/fit_team_verdict.py on missions of
 * scripts/benchmark_team.py, see doc/decisions/056-probability-of-a-place.md. */
struct PlaceModel {
  double constant = 10.63;     ///< Log-odds without evidence
  double runner_up = -8.05;    ///< Log-odds per gain of the best other place over that of the place
  double log_overlap = 3.41;   ///< Log-odds per natural logarithm of the overlap
  double without_place = 0.1;  ///< Largest probability of a pose if the team prefers no place
  double min_overlap = 0.01;   ///< Least overlap; smaller overlaps count as this overlap

  /** Returns the probability that a place is right.
   * \param[in] runner_up_ratio See TeamSearchResult::runner_up. A rival that gains more than the
   * place counts as a rival that gains as much.
   * \param[in] overlap See overlapsWith(). */
  double probability(double runner_up_ratio, double overlap) const;
  /** Returns the largest probability of a pose that is not the place that the team prefers: what
   * the preferred place leaves, and not more than that place has. \param[in] preferred Probability
   * of the place that the team prefers, if there is one. */
  double ofAnotherPose(const std::optional<double>& preferred) const;
};

}  // namespace mrpt::fusion
