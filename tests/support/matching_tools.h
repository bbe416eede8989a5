// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/options.h>

#include <memory>
#include <utility>

#include "fusion_core/features/features.h"
#include "fusion_core/pair/match.h"
#include "fusion_core/pair/verify.h"
#include "fusion_core/registration/two_level.h"
#include "fusion_core/verdict/evaluation.h"

/** \file
 * Calls of the stages of matching with the parameters of Options. */

namespace mrpt::fusion::test {

/** Returns a pointer to a map without ownership. The map must outlive the pointer. */
inline std::shared_ptr<const octomap::OcTree> borrowed(const octomap::OcTree& map) {
  return {std::shared_ptr<const octomap::OcTree>(), &map};
}

/** Returns the features of a map. The map must outlive them. */
inline MapFeatures featuresOf(const octomap::OcTree& map, const Options& options) {
  return computeFeatures(borrowed(map), options.features);
}

/** Runs the two levels from a guess. */
inline MatchResult matchTwoLevel(const MapFeatures& a, const MapFeatures& b,
                                 const Eigen::Isometry3d& T_a_b, const Options& options,
                                 const OnIteration& on_iteration = {}) {
  return matchTwoLevel(a, b, T_a_b, options.registration, options.evaluation.voxels, on_iteration);
}

/** Returns the voxel pairs at a pose. */
inline Pairs pairVoxels(const MapVoxels& a, const MapVoxels& b, const Eigen::Isometry3d& T_a_b,
                        const Options& options) {
  return pairVoxels(a, b, T_a_b, options.registration, options.evaluation.voxels);
}

/** Returns the verdict on a match, or on a given pose and its pairs. */
inline Evaluation judgeMatch(const MapFeatures& a, const MapFeatures& b, const Options& options,
                             const EvaluationParams& evaluation, MatchResult& result) {
  Options asked = options;
  const size_t voxels = options.evaluation.voxels;
  asked.evaluation = evaluation;
  asked.evaluation.voxels = voxels;
  if (result.iterations.empty()) result.covariance = matchAt(a, b, result.T_a_b, asked).covariance;
  return verify(a, b, asked, result);
}

}  // namespace mrpt::fusion::test
