// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstddef>
#include <limits>
#include <string_view>

#include "fusion_base/byte_reader.h"

/** \file
 * Reads the nodes of octrees in the two formats of OctoMap. Checks depth, values and memory. */

namespace mrpt::fusion {

/** Layout of the nodes of an octree. */
enum class NodeLayout {
  LogOdds,           ///< Log-odds and a mask for each node: `.ot` of OcTree and OcTreeStamped
  LogOddsAndColour,  ///< Log-odds, a colour of 3 bytes and a mask: `.ot` of ColorOcTree
  Kinds              ///< Kinds of the children of each inner node, 2 bytes: `.bt` of all trees
};

/** Reads nodes into an octree. */
class NodeReader {
 public:
  /** What to do with infinite log-odds. */
  enum class Infinities {
    Reject,  ///< They are an error
    Clamp    ///< They become the clamping thresholds of the octree
  };

  /** \param[in] bytes The nodes, and bytes that may follow them.
   * \param[in,out] tree An empty octree.
   * \param[in] infinities What to do with infinite log-odds.
   * \param[in] most_memory Largest memory of the nodes, bytes. */
  NodeReader(std::string_view bytes, octomap::OcTree& tree, Infinities infinities,
             size_t most_memory = std::numeric_limits<size_t>::max())
      : in_(bytes), tree_(tree), infinities_(infinities), memory_(most_memory) {}

  /** Reads all nodes.
   * \return Number of nodes.
   * \exception std::runtime_error If the data is truncated, nodes are deeper than 16, log-odds are
   * not finite, or the nodes need too much memory. The octree is then incomplete: discard it. */
  size_t read(NodeLayout layout);

  size_t bytesLeft() const { return in_.size(); }   ///< Number of bytes after the nodes
  bool hasClamped() const { return has_clamped_; }  ///< True if log-odds were infinite
  bool hasColours() const { return has_colours_; }  ///< True if a node had a colour

 private:
  size_t readNode(octomap::OcTreeNode* node, unsigned depth, bool has_colour);
  size_t readKinds(octomap::OcTreeNode* node, unsigned depth);
  float takeLogOdds();
  void takeColour();
  octomap::OcTreeNode* createChild(octomap::OcTreeNode* node, unsigned i);

  ByteReader in_;
  octomap::OcTree& tree_;
  Infinities infinities_;
  size_t memory_;  // bytes that further nodes may need
  bool has_clamped_ = false, has_colours_ = false;
};

}  // namespace mrpt::fusion
