// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Keeps blocks of voxels as ranges in the order of the octree. */
#include "fusion_team/ledger/touched_space.h"

#include <algorithm>

namespace mrpt::fusion {

TouchedSpace::Range TouchedSpace::rangeOf(const OcTreeCube& cube) {
  uint64_t first = 0;
  for (unsigned bit = 0; bit < OcTreeCube::kMaxDepth; bit++)
    for (unsigned axis = 0; axis < 3; axis++)
      first |= static_cast<uint64_t>(cube.key[axis] >> bit & 1U) << (3 * bit + axis);
  return {first, first + (uint64_t{1} << (3 * (OcTreeCube::kMaxDepth - cube.depth)))};
}

void TouchedSpace::addRange(const Range& range) {
  if (!ranges_.empty() && ranges_.back().second == range.first)
    ranges_.back().second = range.second;
  else
    ranges_.push_back(range);
}

void TouchedSpace::addNode(const octomap::OcTree& map, const octomap::OcTreeNode& node,
                           const OcTreeCube& cube) {
  if (cube.depth == kBlockDepth || !map.nodeHasChildren(&node)) return addRange(rangeOf(cube));
  for (unsigned i = 0; i < 8; i++)
    if (map.nodeChildExists(&node, i)) addNode(map, *map.getNodeChild(&node, i), cube.child(i));
}

void TouchedSpace::add(const octomap::OcTree& map) {
  if (map.getRoot()) addNode(map, *map.getRoot(), {});
}

void TouchedSpace::addAll() { ranges_ = {rangeOf({})}; }

void TouchedSpace::finish() {
  std::sort(ranges_.begin(), ranges_.end());
  std::vector<Range> joined;
  for (const Range& r : ranges_)
    if (!joined.empty() && r.first <= joined.back().second)
      joined.back().second = std::max(joined.back().second, r.second);
    else
      joined.push_back(r);
  ranges_ = std::move(joined);
}

TouchedSpace::Share TouchedSpace::shareOf(const OcTreeCube& cube) const {
  const Range wanted = rangeOf(cube);
  const auto next = std::upper_bound(ranges_.begin(), ranges_.end(), wanted.first,
                                     [](uint64_t v, const Range& r) { return v < r.second; });
  if (next == ranges_.end() || next->first >= wanted.second) return Share::None;
  return next->first <= wanted.first && next->second >= wanted.second ? Share::All : Share::Part;
}

}  // namespace mrpt::fusion
