// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>

#include <cstddef>
#include <vector>

#include "fusion_team/pairs/executor.h"
#include "fusion_team/pairs/pair_memory.h"

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
/** Of these matches, those of pairs that meet when the team is placed, over the number of maps. */
constexpr size_t kLaterMatchesPerMap = 1;

/** Chooses the pairs to match: all pairs of at most 25 maps, otherwise kMatchesPerMap for each map
 * less kLaterMatchesPerMap. Each map is matched with the first map, in whose frame the poses are,
 * and with the maps with the largest coarseAgreement(). Pairs whose prior keeps them apart are left
 * out.
 *
 * Cost: a coarse match for each of the n (n-1) / 2 pairs of more than 25 maps.
 *
 * \param[in] maps Whole maps.
 * \param[in] options Parameters of all stages.
 * \param[in,out] executor Runs the comparisons. The result does not depend on it.
 * \param[in,out] memory Keeps the agreements.
 * \return Pairs, sorted by b, then by a. */
std::vector<CandidatePair> candidatePairs(const std::vector<RobotMap>& maps, const Options& options,
                                          Executor& executor, PairMemory& memory);

}  // namespace mrpt::fusion
