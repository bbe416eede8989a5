// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Resampling a small octree at any pose and resolution. */

#include <array>
#include <cmath>
#include <set>

#include "fusion_octree/resampling.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"
#include "support/test_maps.h"

using namespace mrpt::fusion;

namespace {

/** True if few values of the source are looked up: for each block of 4 x 4 x 4 voxels of the new
 * grid that known space meets, 64 or, where the new voxels are larger than the source's, more. */
bool isSmall(const octomap::OcTree& tree, double resolution) {
  constexpr double kMostValues = 1e6;
  const double block = 4 * resolution;
  const double per_block =
      64 * std::pow(std::max(1.0, std::ceil(resolution / tree.getResolution())), 3);
  std::set<std::array<double, 3>> small;
  double blocks = 0;
  for (auto it = tree.begin_leafs(), end = tree.end_leafs(); it != end; ++it) {
    if (it.getSize() < block)
      small.insert({std::floor(it.getX() / block), std::floor(it.getY() / block),
                    std::floor(it.getZ() / block)});
    else
      blocks += std::pow(it.getSize() / block + 1, 3);
  }
  return (blocks + static_cast<double>(small.size())) * per_block < kMostValues;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::Input input(data, size);
  double at[6];
  for (double& number : at) number = input.number();
  const double resolution = input.number();
  const auto tree = fuzz::treeFrom(input);
  if (resolution > 0 && !isSmall(*tree, resolution)) return -1;
  const Eigen::Isometry3d T = test::poseOf(at[0], at[1], at[2], at[3], at[4], at[5]);
  std::unique_ptr<octomap::OcTree> moved;
  if (!fuzz::accepts([&] { moved = transformOcTree(*tree, T, resolution); })) return 0;
  fuzz::require(moved->getResolution() == resolution, "the new grid has the resolution asked for");
  const auto hasObstacle = [](const octomap::OcTree& t) {
    for (auto it = t.begin_leafs(), end = t.end_leafs(); it != end; ++it)
      if (t.isNodeOccupied(*it)) return true;
    return false;
  };
  fuzz::require(hasObstacle(*tree) == hasObstacle(*moved),
                "no obstacle is lost, and none invented");
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  std::vector<std::string> seeds;
  for (const double resolution : {0.125, 0.1, 0.25}) {
    fuzz::Output output;
    for (const double number : {1.5, -2.0, 0.25, 35.0, 1.0, -2.5}) output.number(number);
    output.number(resolution);
    fuzz::describeRoom(output, 0.125);
    seeds.push_back(output.bytes());
  }
  return seeds;
}
