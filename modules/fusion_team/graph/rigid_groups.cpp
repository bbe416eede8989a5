// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Groups of maps that lie alike in two configurations. */
#include "fusion_team/graph/rigid_groups.h"

#include <algorithm>
#include <utility>

namespace mrpt::fusion {

using Eigen::Isometry3d;

std::vector<std::vector<size_t>> rigidGroups(const Configuration& c, const Configuration& other,
                                             const TeamEvidence& evidence) {
  std::vector<size_t> open;
  for (size_t k = 0; k < c.pose.size(); k++)
    if (c.pose[k] && other.pose[k]) open.push_back(k);
  std::vector<std::vector<size_t>> groups;
  while (!open.empty()) {
    std::vector<size_t> largest;
    for (const size_t root : open) {
      const Isometry3d T = *c.pose[root] * other.pose[root]->inverse();
      std::vector<size_t> same;
      for (const size_t k : open)
        if (k == root || evidence.isSame(k, *c.pose[k], T * *other.pose[k])) same.push_back(k);
      if (same.size() > largest.size()) largest = std::move(same);
      if (2 * largest.size() > open.size()) break;  // no other group is larger
    }
    for (const size_t k : largest) open.erase(std::find(open.begin(), open.end(), k));
    groups.push_back(std::move(largest));
  }
  return groups;
}

}  // namespace mrpt::fusion
