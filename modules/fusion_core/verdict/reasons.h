// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>

#include <Eigen/Geometry>
#include <optional>

/** \file
 * The decision on a match, and its reasons in words. */

namespace mrpt::fusion {

/** Input of the decision beside the figures of an evaluation. */
struct Circumstances {
  double voxel_a = 0, voxel_b = 0;         ///< Voxel sizes of both maps, m
  double lone_a = 0, lone_b = 0;           ///< Shares of occupied voxels that touch no other
  std::optional<Eigen::Isometry3d> rival;  ///< Pose of the best rival, if it is known
  double probability_of_staying = 1;       ///< See probabilityOfStaying()
  double probability_without_rival = 0;    ///< Probability of the pose if it had no rival
};

/** Accepts or rejects a match, and says why.
 * \param[in,out] e Figures; receives accepted, is_ambiguous and the reasons. */
void decide(const Circumstances& circumstances, const EvaluationParams& params, Evaluation& e);

}  // namespace mrpt::fusion
