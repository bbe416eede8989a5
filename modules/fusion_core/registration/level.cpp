// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Runs the loop of a level: associate, optimise, shrink the gate. */
#include "fusion_core/registration/level.h"

#include <algorithm>

#include "fusion_core/map/map_voxels.h"
#include "fusion_core/registration/solver.h"

namespace mrpt::fusion {

Pairs firstPairs(Pairing& pairing, const Eigen::Isometry3d& T_a_b, double gate, size_t enough,
                 const Pairs* among) {
  const size_t all = among ? among->size() : pairing.size();
  const size_t stride = strideFor(all, enough);
  Pairs some;
  for (size_t i = 0; i < all; i += stride)
    some.push_back({0, among ? (*among)[i].b : static_cast<uint32_t>(i), 0});
  const Pairs nearest = pairing.associate(T_a_b, DescriptorWeights{}, gate, &some);
  return pairing.associate(T_a_b, pairing.weights(meanSquaredError(nearest)), gate, among);
}

Pairs runLevel(LevelProblem& problem, const LevelParams& level, double least_gate,
               const RegistrationParams& params, MatchResult& result,
               const OnIteration& on_iteration) {
  const double final_gate = std::min(level.gate, std::max(level.final_gate, least_gate));
  double gate = level.gate;
  Pairs pairs = firstPairs(problem, result.T_a_b, gate, params.first_pairs);
  for (unsigned i = 0; i < level.max_iterations; i++) {
    if (pairs.size() < MatchResult::kMinPairs) break;
    const double mse = meanSquaredError(pairs);
    const Eigen::Isometry3d T = optimizePose(
        result.T_a_b, params.solver,
        [&](const Eigen::Isometry3d& at) { return problem.linearize(pairs, at); },
        [&](const Eigen::Isometry3d& at) { return problem.error(pairs, at); });
    const Eigen::Isometry3d step = T * result.T_a_b.inverse();
    // The step of the mean of B's voxels: a rotation about a far origin must not count as a
    // translation.
    const Eigen::Vector3d place = result.T_a_b * problem.middle();
    const IterationRecord record{problem.level(),
                                 pairs.size(),
                                 mse,
                                 (step * place - place).norm(),
                                 Eigen::AngleAxisd(step.linear()).angle(),
                                 T};
    result.T_a_b = T;
    result.iterations.push_back(record);
    if (on_iteration) on_iteration(record);
    const bool gate_is_final = gate <= final_gate;
    // After a longer step the gate stays wide: the far pairs are still needed.
    if (record.step_translation < params.settled_step * gate)
      gate = std::max(final_gate, params.gate_shrink * gate);
    pairs = problem.associate(T, problem.weights(mse), gate, nullptr);
    if (gate_is_final && record.step_translation < params.min_step_translation &&
        record.step_rotation < params.min_step_rotation)
      break;
  }
  return pairs;
}

}  // namespace mrpt::fusion
