// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>

#include "map_pair.h"

/** \file The paper's experiments (Sec. VI), one function each; report.py makes tables and figures
 * of the lines they write. */

namespace mrpt::fusion::benchmark {

/** What to leave out of a run. */
struct Effort {
  unsigned stride = 1;  ///< take every so many-th start, cut, ...
  unsigned rounds = 5;  ///< measure times so often
  std::string kind;     ///< the only kind of maps to judge; empty: all kinds
};

/** Table II: sizes of the maps and their overlap. */
void describeData(const MapPair& pair, std::ostream& csv);

/** Figs. 12-14, Tables III and IV: one method from the 125 starts. \param[out] inliers Fig. 15.
 * \param[out] costs Preprocessing and memory. */
void alignFromStarts(const MapPair& pair, const std::string& method, const Effort& effort,
                     std::ostream& csv, std::ostream& inliers, std::ostream& costs);

/** Fig. 10: error after each iteration of ICP on edges and of the first level of PMM. */
void matchEdges(const MapPair& pair, const Effort& effort, std::ostream& csv);

/** Fig. 11: map B is cut metre by metre on the side where it overlaps map A. */
void reduceOverlap(const MapPair& pair, const Effort& effort, std::ostream& csv);

/** Without a guess: from poses that are off by up to 20 m and any yaw, of the whole pair and of
 * parts that overlap less. Errors are of B's middle; times are of a whole match. */
void alignFromAnywhere(const MapPair& pair, const Effort& effort, std::ostream& csv);

/** Whether verdicts can be trusted, and what the probability of being right is worth: matches
 * without a guess, from a near one and from a wrong one, of random parts of both maps, which
 * overlap by anything from all to nothing, and of map A with the mirror image of B, where no pose
 * is right (error: infinity). With neesOf() each. */
void judgeVerdicts(const MapPair& pair, const Effort& effort, std::ostream& csv);

/** Maps that differ: of other voxel sizes, of occupied and free without probabilities, of
 * probabilities that were never clamped, of a sensor that saw a third of the voxels. */
void mixMaps(const MapPair& pair, const Effort& effort, std::ostream& csv);

/** Table V: each merging policy at the true pose, also against the pair's reference map. */
void mergeByPolicy(const MapPair& pair, std::ostream& csv);

/** What each step beyond the paper contributes: the default without it, from the 125 starts. */
void ablate(const MapPair& pair, const Effort& effort, std::ostream& csv);

/** The time of a whole match from nearStart(), preparation included: our default, on one and on two
 * threads, and PCL's methods by turns, so that what else the machine does meets all alike.
 * \exception std::runtime_error If two threads come to another pose than one. */
void compareSpeed(const MapPair& pair, const Effort& effort, std::ostream& csv);

}  // namespace mrpt::fusion::benchmark
