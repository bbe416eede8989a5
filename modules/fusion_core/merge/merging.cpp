// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Merges two octrees voxel by voxel. */
#include <mrpt/fusion/merging.h>

#include <algorithm>
#include <cmath>

#include "fusion_base/bits.h"
#include "fusion_octree/build.h"
#include "fusion_octree/resampling.h"

namespace mrpt::fusion {
namespace {
using octomap::OcTree;
using octomap::OcTreeNode;

double clampedProbability(double p) { return std::clamp(p, 1e-6, 1 - 1e-6); }
double probabilityOf(float log_odds) { return octomap::probability(log_odds); }
float logOddsOf(double p) { return octomap::logodds(clampedProbability(p)); }

/** As fuseLogOdds(), but the compiler may put it in the place of its calls. */
inline float fuse(float a, float b, const MergeParams& params, float clamp_min, float clamp_max) {
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

/** Traverses map A and map B on A's grid together. A leaf counts as all cubes in it. */
class MergeVisitor {
 public:
  struct State {
    const OcTreeNode* a;
    CubeRange b;
  };

  MergeVisitor(const OcTree& a, const CubeList& b, const MergeParams& params)
      : a_(a),
        b_(b),
        params_(params),
        clamp_min_(a.getClampingThresMinLog()),
        clamp_max_(a.getClampingThresMaxLog()) {}

  State rootState() const { return {a_.getRoot(), CubeListVisitor(b_).rootState()}; }

  OcTreeFill visit(const OcTreeCube& cube, const State& s) {
    if (!s.a) return CubeListVisitor::visit(cube, s.b);
    if (s.b.empty()) return OcTreeFill::copyInParts(*s.a, cube);
    if (!OcTreeAccess::hasChildren(*s.a) && s.b.isLeafOf(cube))
      return OcTreeFill::leaf(fused(s.a->getLogOdds(), s.b.begin->log_odds));
    if (cube.depth < VoxelBlock::kDepth) return OcTreeFill::split();
    fuseBlock(cube, *s.a, s.b);
    return OcTreeFill::voxels(block_);
  }

  State descend(const State& s, unsigned i, const OcTreeCube& child) const {
    return {childOrSelf(a_, s.a, i), s.b.in(i, child)};
  }

 private:
  float fused(float a, float b) const { return fuse(a, b, params_, clamp_min_, clamp_max_); }

  void fuseBlock(const OcTreeCube& cube, const OcTreeNode& a, const CubeRange& b) {
    block_.known = 0;
    block_.add(a);
    if (b.isLeafOf(cube)) b_leaf_.fill(b.begin->log_odds);
    const VoxelBlock& other = b.isLeafOf(cube) ? b_leaf_ : *b.block();
    for (uint64_t both = block_.known & other.known; both; both &= both - 1) {
      const auto i = static_cast<size_t>(lowestBit(both));
      block_.value[i] = fused(block_.value[i], other.value[i]);
    }
    for (uint64_t only_b = other.known & ~block_.known; only_b; only_b &= only_b - 1) {
      const auto i = static_cast<size_t>(lowestBit(only_b));
      block_.value[i] = other.value[i];
    }
    block_.known |= other.known;
  }

  const OcTree& a_;
  const CubeList& b_;
  const MergeParams& params_;
  float clamp_min_, clamp_max_;
  VoxelBlock block_, b_leaf_;
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
  return fuse(a, b, params, clamp_min, clamp_max);
}

std::unique_ptr<OcTree> mergeMaps(const OcTree& a, const OcTree& b, const Eigen::Isometry3d& T_a_b,
                                  const MergeParams& params) {
  const CubeList b_in_a = resampledCubes(b, T_a_b, a.getResolution());
  auto fused = std::make_unique<OcTree>(a.getResolution());
  OcTreeAccess::setSensorModel(*fused, OcTreeAccess::sensorModel(a));
  buildOcTreeInParallel(*fused, MergeVisitor(a, b_in_a, params));
  return fused;
}

}  // namespace mrpt::fusion
