// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <memory>
#include <utility>
#include <vector>

/** \file
 * The paper's Sec. V-B: merges two maps into one. */

namespace mrpt::fusion {

/** Rule for the value of a voxel that is known in both maps. */
enum class MergePolicy {
  RelativeEntropy,  ///< The paper's filter, eqs. (26)-(28): weighted mean up to the KL threshold,
                    ///< otherwise the higher probability
  Average,          ///< Mean of the probabilities (a baseline of the paper)
  Stitch,           ///< Value of map A; B only fills space that is unknown in A (a baseline of
                    ///< the paper)
  Bayes  ///< Sum of the log-odds: the observations of both maps count as independent (the default:
         ///< nearest to the truth, see doc/benchmarks.md)
};

/** Returns the policies with their names in .ini files and on the command line. */
MRPT_FUSION_API const std::vector<std::pair<MergePolicy, const char*>>& mergePolicyNames();

/** Settings of mergeMaps(). */
struct MergeParams {
  MergePolicy policy = MergePolicy::Bayes;  ///< Rule for voxels known in both maps
  double kl_threshold = 0.1;  ///< Largest relativeEntropy() for the mean, nats (Table I)
  /** If true, maps with the same sources all count, see Counting. mergeMaps() does not compare
   * sources. */
  bool independent = false;
};

/** Eq. (27): returns KL(p || q) of two occupancy probabilities, nats, >= 0, not symmetric. The
 * probabilities are first clamped to [1e-6, 1 - 1e-6]. */
MRPT_FUSION_API double relativeEntropy(double p, double q);

/** Eq. (28): returns the mean of two probabilities, each weighted by itself. It is never below the
 * unweighted mean. */
MRPT_FUSION_API double weightedMean(double p, double q);

/** Returns the fused value of a voxel that is known in both maps.
 * \param[in] a,b Log-odds in map A and map B.
 * \param[in] params The policy.
 * \param[in] clamp_min,clamp_max Clamping thresholds of the result, log-odds.
 * \return Log-odds. Sums of the policy Bayes stay within [clamp_min, clamp_max]. If an input lies
 * outside of that range, the range is extended to the input. */
MRPT_FUSION_API float fuseLogOdds(float a, float b, const MergeParams& params, float clamp_min,
                                  float clamp_max);

/** Merges occupied, free and unknown space of two maps.
 *
 * transformOcTree() resamples map B onto map A's grid. A place that is known in only one
 * map has the value of that map. A place that is unknown in both maps stays unknown.
 * Cost: transformOcTree() plus one traversal of both octrees.
 * \param[in] a,b The maps.
 * \param[in] T_a_b Pose of map B in A's frame.
 * \param[in] params The policy.
 * \return A new pruned octree in A's frame, with A's resolution and sensor model.
 * \exception std::invalid_argument, std::out_of_range As transformOcTree().
 */
MRPT_FUSION_API std::unique_ptr<octomap::OcTree> mergeMaps(const octomap::OcTree& a,
                                                           const octomap::OcTree& b,
                                                           const Eigen::Isometry3d& T_a_b,
                                                           const MergeParams& params);

}  // namespace mrpt::fusion
