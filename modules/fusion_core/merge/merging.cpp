// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Merges two octrees voxel by voxel. */
#include <mrpt/fusion/merging.h>

#include <algorithm>
#include <cmath>

#include "fusion_octree/build.h"
#include "fusion_octree/resampling.h"

namespace mrpt::fusion {
namespace {
using octomap::OcTree;
using octomap::OcTreeNode;

double clampedProbability(double p) { return std::clamp(p, 1e-6, 1 - 1e-6); }
double probabilityOf(float log_odds) { return octomap::probability(log_odds); }
float logOddsOf(double p) { return octomap::logodds(clampedProbability(p)); }

/** Traverses two octrees on the same grid together. A pruned leaf counts as all cubes in it. */
class MergeVisitor {
 public:
  struct State {
    const OcTreeNode* a;
    const OcTreeNode* b;
  };

  MergeVisitor(const OcTree& a, const OcTree& b, const MergeParams& params)
      : a_(a), b_(b), params_(params) {}

  State rootState() const { return {a_.getRoot(), b_.getRoot()}; }

  OcTreeFill visit(const OcTreeCube&, const State& s) const {
    if (!s.a && !s.b) return OcTreeFill::unknown();
    if ((s.a && a_.nodeHasChildren(s.a)) || (s.b && b_.nodeHasChildren(s.b)))
      return OcTreeFill::split();
    if (!s.b) return OcTreeFill::leaf(s.a->getLogOdds());
    if (!s.a) return OcTreeFill::leaf(s.b->getLogOdds());
    return OcTreeFill::leaf(fuseLogOdds(s.a->getLogOdds(), s.b->getLogOdds(), params_,
                                        a_.getClampingThresMinLog(), a_.getClampingThresMaxLog()));
  }

  State descend(const State& s, unsigned i, const OcTreeCube&) const {
    return {childOrSelf(a_, s.a, i), childOrSelf(b_, s.b, i)};
  }

 private:
  const OcTree& a_;
  const OcTree& b_;
  const MergeParams& params_;
};

}  // namespace

const std::vector<std::pair<MergePolicy, const char*>>& mergePolicyNames() {
  static const std::vector<std::pair<MergePolicy, const char*>> names = {
      {MergePolicy::RelativeEntropy, "relative_entropy"},
      {MergePolicy::Average, "average"},
      {MergePolicy::Stitch, "stitch"},
      {MergePolicy::Bayes, "bayes"}};
  return names;
}

double relativeEntropy(double p, double q) {
  p = clampedProbability(p);
  q = clampedProbability(q);
  return p * std::log(p / q) + (1 - p) * std::log((1 - p) / (1 - q));
}

double weightedMean(double p, double q) { return p + q > 0 ? (p * p + q * q) / (p + q) : 0; }

float fuseLogOdds(float a, float b, const MergeParams& params, float clamp_min, float clamp_max) {
  switch (params.policy) {
    case MergePolicy::RelativeEntropy: {
      if (a == b) return a;
      const double p = probabilityOf(a), q = probabilityOf(b);
      if (relativeEntropy(p, q) > params.kl_threshold) return std::max(a, b);
      return logOddsOf(weightedMean(p, q));
    }
    case MergePolicy::Average:
      return a == b ? a : logOddsOf(0.5 * (probabilityOf(a) + probabilityOf(b)));
    case MergePolicy::Stitch:
      return a;
    case MergePolicy::Bayes:
      return std::clamp(a + b, std::min({clamp_min, a, b}), std::max({clamp_max, a, b}));
  }
  return a;
}

std::unique_ptr<OcTree> mergeMaps(const OcTree& a, const OcTree& b, const Eigen::Isometry3d& T_a_b,
                                  const MergeParams& params) {
  const auto b_in_a = transformOcTree(b, T_a_b, a.getResolution());
  auto fused = std::make_unique<OcTree>(a.getResolution());
  OcTreeAccess::setSensorModel(*fused, OcTreeAccess::sensorModel(a));
  buildOcTreeInParallel(*fused, MergeVisitor(a, *b_in_a, params));
  return fused;
}

}  // namespace mrpt::fusion
