// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <memory>
#include <utility>
#include <vector>

/** \file
 * The paper's Sec. V-B: one map of two. */

namespace mrpt::fusion {

/** What a voxel holds that both maps know. */
enum class MergePolicy {
  RelativeEntropy,  ///< the paper's filter, eqs. (26)-(28): within the KL threshold the weighted
                    ///< mean, beyond it the higher probability
  Average,          ///< mean of the probabilities (a baseline of the paper)
  Stitch,           ///< map A's value: the maps are laid side by side, B fills in what A does not
                    ///< know (a baseline of the paper)
  Bayes  ///< sum of the log-odds: both maps' observations counted as independent (the default:
         ///< nearest to the truth, see doc/benchmarks.md)
};

/** The policies with their names in .ini files and on the command line. */
MRPT_FUSION_API const std::vector<std::pair<MergePolicy, const char*>>& mergePolicyNames();

/** Settings of mergeMaps(). */
struct MergeParams {
  MergePolicy policy = MergePolicy::Bayes;  ///< for voxels that both maps know
  double kl_threshold = 0.1;                ///< of relativeEntropy(), nats (Table I)
};

/** Eq. (27): KL(p || q) of two occupancy probabilities, nats, >= 0, not symmetric. Probabilities
 * are first clamped to [1e-6, 1 - 1e-6]. */
MRPT_FUSION_API double relativeEntropy(double p, double q);

/** Eq. (28): the mean of two probabilities, each weighted by itself; never below their mean. */
MRPT_FUSION_API double weightedMean(double p, double q);

/** The fused value of a voxel known to both maps.
 * \param[in] a,b Log-odds in map A (model) and map B (scene). \param[in] params The policy.
 * \param[in] clamp_min,clamp_max Clamping thresholds of the result, log-odds. \return Log-odds.
 * Bayes sums stay within [clamp_min, clamp_max], or the inputs where they lie outside. */
MRPT_FUSION_API float fuseLogOdds(float a, float b, const MergeParams& params, float clamp_min,
                                  float clamp_max);

/** Merges whole maps: occupied, free and unknown space.
 *
 * Map B is resampled onto map A's grid (transformOcTree); where only one map knows a
 * place, the result has its value; where neither does, it stays unknown.
 * \param[in] a,b The maps.
 * \param[in] T_a_b Pose of map B in A's frame.
 * \param[in] params The policy.
 * \return A new pruned tree in A's frame, with A's resolution and sensor model. The inputs are not
 * modified. \exception std::invalid_argument, std::out_of_range As transformOcTree().
 * Cost: that of transformOcTree() plus one traversal of both trees.
 */
MRPT_FUSION_API std::unique_ptr<octomap::OcTree> mergeMaps(const octomap::OcTree& a,
                                                           const octomap::OcTree& b,
                                                           const Eigen::Isometry3d& T_a_b,
                                                           const MergeParams& params);

}  // namespace mrpt::fusion
