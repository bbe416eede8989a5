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
 * The stages of matching with the parameters that all options hold. */

namespace mrpt::fusion::test {

/** A map that outlives everything that refers to it. */
inline std::shared_ptr<const octomap::OcTree> borrowed(const octomap::OcTree& map) {
  return {std::shared_ptr<const octomap::OcTree>(), &map};
}

/** Features of a map that outlives them. */
inline MapFeatures featuresOf(const octomap::OcTree& map, const Options& options) {
  return computeFeatures(borrowed(map), options.features);
}

/** The two levels from a guess. */
inline MatchResult matchTwoLevel(const MapFeatures& a, const MapFeatures& b,
                                 const Eigen::Isometry3d& T_a_b, const Options& options,
                                 const OnIteration& on_iteration = {}) {
  return matchTwoLevel(a, b, T_a_b, options.registration, options.evaluation.voxels, on_iteration);
}

/** The voxel pairs at a pose. */
inline Pairs pairVoxels(const MapVoxels& a, const MapVoxels& b, const Eigen::Isometry3d& T_a_b,
                        const Options& options) {
  return pairVoxels(a, b, T_a_b, options.registration, options.evaluation.voxels);
}

/** The verdict on a match, or on a given pose and its pairs. */
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
