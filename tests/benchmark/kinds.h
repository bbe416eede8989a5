// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <vector>

#include "experiments.h"
#include "map_pair.h"

/** \file
 * Verdicts on maps of all kinds: the data that the verdict's model is fitted to. */

namespace mrpt::fusion::benchmark {

/** Matches without a guess of random parts of a pair, as it is and changed to other kinds: coarse
 * voxels, no free space in both maps or in B, a third of the obstacles, one layer. Then matches of
 * map A with maps of other places and with the mirror image of B, of which no pose is right (error:
 * infinity). Writes each verdict with its evidence.
 * \param[in] pair The pair.
 * \param[in] others Pairs of other places.
 * \param[in] effort Takes every stride-th part.
 * \param[out] csv Table "kinds". */
void judgeKinds(const MapPair& pair, const std::vector<MapPair>& others, const Effort& effort,
                std::ostream& csv);

}  // namespace mrpt::fusion::benchmark
