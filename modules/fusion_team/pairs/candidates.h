// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>

#include <cstddef>
#include <vector>

#include "fusion_team/pairs/executor.h"

/** \file
 * Chooses the pairs of a team that are matched. */

namespace mrpt::fusion {

/** The indices of two maps. */
struct CandidatePair {
  size_t a;  ///< Index of map A
  size_t b;  ///< Index of map B; larger than a

  bool operator==(const CandidatePair& other) const { return a == other.a && b == other.b; }
};

/** Largest number of matches of a team, over its number of maps. */
constexpr size_t kMatchesPerMap = 12;

/** Chooses the pairs to match: all pairs of at most 25 maps, otherwise kMatchesPerMap for each map.
 * Each map is matched with the first map, in whose frame the poses are, and with the maps that look
 * most like it: each surrounding of its Signature votes for the maps with the most similar
 * surroundings. Pairs whose prior keeps them apart are left out of the vote.
 * Cost: O(n^2) products of signatures for n maps.
 * \param[in] maps Whole maps.
 * \param[in] options Parameters of all stages.
 * \param[in,out] executor Runs the comparisons. The result does not depend on it.
 * \return Pairs, sorted by b, then by a. */
std::vector<CandidatePair> candidatePairs(const std::vector<RobotMap>& maps, const Options& options,
                                          Executor& executor);

}  // namespace mrpt::fusion
