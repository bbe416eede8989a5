// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Converts edge voxels to octrees and to PLY text. */
#include <mrpt/core/exceptions.h>
#include <mrpt/fusion/edges.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "fusion_core/features/edges.h"
#include "fusion_octree/walk.h"

namespace mrpt::fusion {
namespace {

/** Makes an octree of edge voxels. \a value converts the probability to the value of the leaf. */
template <class F>
octomap::OcTree treeOf(const EdgeVoxels& edges, F&& value) {
  ASSERTMSG_(edges.resolution > 0 && std::isfinite(edges.resolution),
             "edge voxels: the resolution must be a positive length");
  octomap::OcTree tree(edges.resolution);
  for (size_t i = 0; i < edges.size(); i++) {
    octomap::OcTreeKey key;
    const Eigen::Vector3f& c = edges.centre[i];
    ASSERTMSG_(keyAt(tree, {c.x(), c.y(), c.z()}, key),
               "an edge voxel lies outside the octree's grid");
    const float p = edges.probability[i];
    ASSERTMSG_(p > 0 && p <= 1, "edge voxels: a probability is not in (0,1]");
    tree.setNodeValue(key, 0.F, true)->setLogOdds(value(p));
  }
  tree.updateInnerOccupancy();
  return tree;
}

}  // namespace

octomap::OcTree occupancyTree(const EdgeVoxels& edges) {
  constexpr float kMost = 0.999F;  // the log-odds of probability 1 are infinite
  if (edges.size() == 0) return octomap::OcTree(0.1);
  return treeOf(edges, [=](float p) { return octomap::logodds(std::min(p, kMost)); });
}

octomap::OcTree probabilityTree(const EdgeVoxels& edges) {
  return treeOf(edges, [](float p) { return p; });
}

EdgeVoxels edgesOf(const octomap::OcTree& tree, double direction_radius) {
  std::vector<octomap::OcTreeKey> at;
  std::vector<float> probability;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it) {
    ASSERTMSG_(
        it.getDepth() == tree.getTreeDepth() && it->getLogOdds() > 0 && it->getLogOdds() <= 1,
        "corrupt stream: not edge voxels");
    at.push_back(it.getKey());
    probability.push_back(it->getLogOdds());
  }
  return edgeVoxelsAt(at, std::move(probability), tree, direction_radius);
}

std::string toPly(const EdgeVoxels& edges) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\n"
      << "comment structural edge voxels: nx ny nz is the direction of the edge\n"
      << "element vertex " << edges.size() << "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "probability", "linearity"})
    out << "property float " << name << "\n";
  out << "end_header\n";
  for (size_t i = 0; i < edges.size(); i++) {
    const Eigen::Vector3d tau = edges.covariance[i].direction();
    out << edges.centre[i].transpose() << " " << tau.transpose() << " " << edges.probability[i]
        << " " << edges.covariance[i].linearity() << "\n";
  }
  return out.str();
}

}  // namespace mrpt::fusion
