// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Lists keys, ranges and meanings of the parameters of merging. */
#include "fusion_core/merge/parameters.h"

namespace mrpt::fusion {

Parameters parametersOf(MergeParams& params) {
  return {
      choice("merge_policy", params.policy, mergePolicyNames(),
             "Value of voxels that are known in both maps: " + listOf(mergePolicyNames())),
      number("kl_threshold", params.kl_threshold, 0, kUnlimited,
             "Relative entropy up to which probabilities are averaged, nats (Table I: 0.1)"),
  };
}

}  // namespace mrpt::fusion
