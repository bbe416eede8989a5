// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstddef>

/** \file
 * Access to members of octrees that OctoMap keeps to itself. */

namespace mrpt::fusion {

/** Access to protected members of octomap::OcTree: root, and log-odds of the sensor model. */
class OcTreeAccess : private octomap::OcTree {
 public:
  /** Creates the root node of an empty octree. */
  static octomap::OcTreeNode* createRoot(octomap::OcTree& tree) {
    setRoot(tree, new octomap::OcTreeNode(), 1);
    return tree.getRoot();
  }

  /** Makes a node the root of an empty octree, with all nodes below it.
   * \param[in,out] tree The octree.
   * \param[in] node The node; the octree owns it from now on.
   * \param[in] nodes Number of nodes, with the root. */
  static void setRoot(octomap::OcTree& tree, octomap::OcTreeNode* node, size_t nodes) {
    tree.*(&OcTreeAccess::root) = node;
    tree.*(&OcTreeAccess::tree_size) = nodes;
    tree.*(&OcTreeAccess::size_changed) = true;
  }

  /** Returns the array of the 8 children of a node; null for a leaf. The node owns the array and
   * the children. */
  static octomap::AbstractOcTreeNode**& childrenOf(octomap::OcTreeNode& node) {
    struct Node : octomap::OcTreeNode {
      static octomap::AbstractOcTreeNode**& childrenOf(octomap::OcTreeNode& n) {
        return n.*(&Node::children);
      }
    };
    return Node::childrenOf(node);
  }
  /** Returns the array of the children of a node that is not to be changed. */
  static octomap::AbstractOcTreeNode* const* childrenOf(const octomap::OcTreeNode& node) {
    struct Node : octomap::OcTreeNode {
      static octomap::AbstractOcTreeNode* const* childrenOf(const octomap::OcTreeNode& n) {
        return n.*(&Node::children);
      }
    };
    return Node::childrenOf(node);
  }
  /** Returns whether a node has children. */
  static bool hasChildren(const octomap::OcTreeNode& node) {
    const auto* children = childrenOf(node);
    if (!children) return false;
    for (unsigned i = 0; i < 8; i++)
      if (children[i]) return true;
    return false;
  }
  /** Returns the i-th child of a node with children; null if the child's cube is unknown. */
  static const octomap::OcTreeNode* child(const octomap::OcTreeNode& node, unsigned i) {
    return static_cast<const octomap::OcTreeNode*>(childrenOf(node)[i]);
  }

  /** Counts nodes that were created or, if \a count is negative, deleted. */
  static void addNodes(octomap::OcTree& tree, int64_t count) {
    tree.*(&OcTreeAccess::tree_size) += static_cast<size_t>(count);
    tree.*(&OcTreeAccess::size_changed) = true;
  }

  /** Returns whether an octree records which voxels change. */
  static bool recordsChanges(const octomap::OcTree& tree) {
    return tree.*(&OcTreeAccess::use_change_detection);
  }

  /** The 5 log-odds of the sensor model, bit for bit. OctoMap's setters take probabilities and
   * round. */
  struct SensorModel {
    float clamp_min;            ///< Lowest log-odds of a voxel
    float clamp_max;            ///< Highest log-odds of a voxel
    float hit;                  ///< Change by a hit, log-odds
    float miss;                 ///< Change by a miss, log-odds
    float occupancy_threshold;  ///< Least log-odds of an occupied voxel
  };
  /** Returns the sensor model of an octree. */
  static SensorModel sensorModel(const octomap::OcTree& t) {
    return {t.getClampingThresMinLog(), t.getClampingThresMaxLog(), t.getProbHitLog(),
            t.getProbMissLog(), t.getOccupancyThresLog()};
  }
  /** Sets the sensor model of an octree. The voxels do not change. */
  static void setSensorModel(octomap::OcTree& t, const SensorModel& m) {
    t.*(&OcTreeAccess::clamping_thres_min) = m.clamp_min;
    t.*(&OcTreeAccess::clamping_thres_max) = m.clamp_max;
    t.*(&OcTreeAccess::prob_hit_log) = m.hit;
    t.*(&OcTreeAccess::prob_miss_log) = m.miss;
    t.*(&OcTreeAccess::occ_prob_thres_log) = m.occupancy_threshold;
  }
};

}  // namespace mrpt::fusion
