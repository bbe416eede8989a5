// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Derives the prior of a pair of maps from what is known of each map. */
#include "fusion_team/pairs/pair_prior.h"

namespace mrpt::fusion {
namespace {

/** Returns the prior of A's pose in B's frame. */
Prior inverseOf(const Prior& prior) {
  if (prior.isNone()) return Prior::none();
  if (!prior.statesCovariance()) return Prior::near(-prior.guess());
  mrpt::poses::CPose3DPDFGaussian inverse;
  prior.pdf().inverse(inverse);
  return Prior::gaussian(inverse);
}

}  // namespace

Prior priorOf(const RobotMap& map, const RobotMap& in) {
  for (const PoseGuess& guess : map.guesses)
    if (guess.robot == in.robot) return guess.prior;
  for (const PoseGuess& guess : in.guesses)
    if (guess.robot == map.robot) return inverseOf(guess.prior);
  const double unknown = kUnknownPoseSigma * kUnknownPoseSigma;
  for (const auto& cov : {map.pose.cov, in.pose.cov})
    if (cov(0, 0) >= unknown) return Prior::none();
  return Prior::gaussian(map.pose - in.pose);
}

}  // namespace mrpt::fusion
