// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/merging.h>

#include "support/reference_resampling.h"

/** \file
 * The twin of mergeMaps(): both octrees are built, and their nodes are visited one by one. */

namespace map_tests::reference {

/** Traverses two octrees on the same grid together. A pruned leaf counts as all cubes in it. */
class MergeVisitor {
 public:
  struct State {
    const OcTreeNode* a;
    const OcTreeNode* b;
  };

  MergeVisitor(const OcTree& a, const OcTree& b, const mrpt::fusion::MergeParams& params)
      : a_(a), b_(b), params_(params) {}

  State rootState() const { return {a_.getRoot(), b_.getRoot()}; }

  OcTreeFill visit(const OcTreeCube&, const State& s) const {
    if (!s.a && !s.b) return OcTreeFill::unknown();
    if ((s.a && a_.nodeHasChildren(s.a)) || (s.b && b_.nodeHasChildren(s.b)))
      return OcTreeFill::split();
    if (!s.b) return OcTreeFill::leaf(s.a->getLogOdds());
    if (!s.a) return OcTreeFill::leaf(s.b->getLogOdds());
    return OcTreeFill::leaf(mrpt::fusion::fuseLogOdds(s.a->getLogOdds(), s.b->getLogOdds(), params_,
                                                      a_.getClampingThresMinLog(),
                                                      a_.getClampingThresMaxLog()));
  }

  State descend(const State& s, unsigned i, const OcTreeCube&) const {
    return {mrpt::fusion::childOrSelf(a_, s.a, i), mrpt::fusion::childOrSelf(b_, s.b, i)};
  }

 private:
  const OcTree& a_;
  const OcTree& b_;
  const mrpt::fusion::MergeParams& params_;
};

/** Returns what mergeMaps() must return. */
inline std::unique_ptr<OcTree> merged(const OcTree& a, const OcTree& b,
                                      const Eigen::Isometry3d& T_a_b,
                                      const mrpt::fusion::MergeParams& params) {
  const auto b_in_a = transformed(b, T_a_b, a.getResolution());
  MergeVisitor visitor(a, *b_in_a, params);
  return built(a.getResolution(), OcTreeAccess::sensorModel(a), visitor.rootState(), visitor);
}

}  // namespace map_tests::reference
