// SPDX-License-Identifier: BSD-3-Clause
#include <tbb/global_control.h>

#include "support/tree_tools.h"

namespace map_tests {
namespace {

using mrpt::fusion::OcTreeCube;
using mrpt::fusion::OcTreeFill;

/** A ball of some radius (voxels) about a key: its shell is split down to voxels of alternating
 * values, its inside is one leaf after the other as large as fits. */
struct BallVisitor {
  struct State {};
  octomap::OcTreeKey centre;
  double radius;

  State rootState() const { return {}; }
  State descend(const State&, unsigned, const OcTreeCube&) const { return {}; }
  OcTreeFill visit(const OcTreeCube& cube, const State&) const {
    double nearest = 0, farthest = 0;
    for (unsigned axis = 0; axis < 3; axis++) {
      const double low = static_cast<double>(cube.key[axis]) - centre[axis];
      const double high = low + cube.side() - 1;
      const double near = low > 0 ? low : high < 0 ? -high : 0;
      const double far = std::max(std::abs(low), std::abs(high));
      nearest += near * near;
      farthest += far * far;
    }
    if (nearest > radius * radius) return OcTreeFill::unknown();
    if (farthest <= radius * radius) return OcTreeFill::leaf(-1.5F);
    if (cube.depth < OcTreeCube::kMaxDepth) return OcTreeFill::split();
    return OcTreeFill::leaf((cube.key[0] + cube.key[1]) % 2 ? 0.5F : 2.F);
  }
};

std::unique_ptr<octomap::OcTree> built(const BallVisitor& visitor) {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  BallVisitor own(visitor);
  mrpt::fusion::buildOcTree(*tree, {}, own);
  return tree;
}

std::unique_ptr<octomap::OcTree> builtInParallel(const BallVisitor& visitor, size_t threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  mrpt::fusion::buildOcTreeInParallel(*tree, visitor);
  return tree;
}

TEST(OcTreeBuild, InParallelIsTheSameTree) {
  const octomap::OcTreeKey middle(32768, 32768, 32768), corner(3, 65530, 40000);
  for (const BallVisitor& ball :
       {BallVisitor{middle, 60}, BallVisitor{corner, 21}, BallVisitor{middle, 2},
        BallVisitor{middle, -1}, BallVisitor{middle, 1e6}}) {
    const auto expected = built(ball);
    for (const size_t threads : {1, 2, 4}) {
      const auto tree = builtInParallel(ball, threads);
      EXPECT_EQ(nodesOf(*tree), nodesOf(*expected));
      EXPECT_EQ(tree->size(), expected->size());
      EXPECT_EQ(tree->size(), tree->calcNumNodes());
    }
  }
}

TEST(OcTreeBuild, TreesBuiltInParallelCanBeChanged) {
  const octomap::OcTreeKey middle(32768, 32768, 32768);
  const BallVisitor ball{middle, 60};
  const auto expected = built(ball), tree = builtInParallel(ball, 2);
  for (auto* t : {expected.get(), tree.get()}) {
    t->updateNode(middle, true);            // splits a leaf
    t->updateNode(100.F, 0.F, 0.F, false);  // beyond
    t->prune();
    t->deleteNode(octomap::OcTreeKey(32768 + 59, 32768, 32768));
  }
  EXPECT_EQ(nodesOf(*tree), nodesOf(*expected));
  EXPECT_EQ(tree->size(), tree->calcNumNodes());
  EXPECT_GT(tree->getNumLeafNodes(), 1000U);
}

}  // namespace
}  // namespace map_tests
