// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <memory>

#include "map_pair.h"

/** \file What merged maps are measured against, where a simulator knows it. */

namespace mrpt::fusion::benchmark {

/** Maps in A's frame and resolution that know the same places: those that the two robots have seen.
 */
struct Truth {
  /** What one robot would have built of both robots' scans, had it known its poses. */
  std::shared_ptr<const octomap::OcTree> reference;
  /** Whether the building has an obstacle there; people and what glass returns are none. */
  std::shared_ptr<const octomap::OcTree> building;
};

/** Whether the pair's folder has a reference. */
bool hasTruth(const MapPair& pair);

/** Reads reference.ot and, for the building, world.bt and T_a_w.txt (its pose in A's frame) from
 * the pair's folder; both are null unless hasTruth(). */
Truth loadTruth(const MapPair& pair);

/** The places that \a known knows, occupied where \a world is and else free. Both have one grid. */
std::shared_ptr<const octomap::OcTree> labelled(const octomap::OcTree& known,
                                                const octomap::OcTree& world);

/** How near a map comes to the truth: over all voxels that the truth knows, a pruned leaf counting
 * as the voxels it stands for. Where the map knows nothing, its probability is 0.5. */
struct TruthComparison {
  double log_loss = 0;  ///< mean, nats
  double brier = 0;     ///< mean squared error of the probability
  double f1 = 0;        ///< of "occupied": harmonic mean of precision and recall
};
TruthComparison compareWithTruth(const octomap::OcTree& truth, const octomap::OcTree& map);

}  // namespace mrpt::fusion::benchmark
