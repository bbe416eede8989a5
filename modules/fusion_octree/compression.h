// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <string>
#include <string_view>

#include "fusion_base/packing.h"

/** \file
 * Compression of octrees for slow links: about half the size of a gzipped `.ot` file.
 */

namespace mrpt::fusion {

/** Compresses the nodes of an octree: all values and the structure, bit for bit.
 *
 * Similar data is grouped before it is packed: first the masks of children in pre-order, then the
 * values of the leaves as indices into a table of the distinct values. Inner nodes that hold the
 * maximum of their children, as in OctoMap, need no data.
 *
 * | packing | size, beside `.ot` with gzip -6 | time for 1 million leaves |
 * | --- | --- | --- |
 * | Packing::Fast | 0.52 to 0.54 times | 0.1 s |
 * | Packing::Smallest | 0.47 to 0.49 times | 0.7 s |
 * \exception std::length_error If the octree has more than kMostCompressedNodes nodes. */
std::string compressNodes(const octomap::OcTree& tree, Packing packing = Packing::Fast);

/** \overload
 * Compresses a node of an octree and all nodes below it.
 * \param[in] node The node.
 * \param[in] depth Depth of the node.
 * \param[in] packing How the bytes are packed. */
std::string compressNodes(const octomap::OcTreeNode& node, unsigned depth,
                          Packing packing = Packing::Fast);

/** Largest number of nodes: 50 times the nodes of a large building at 0.1 m. */
constexpr size_t kMostCompressedNodes = 50'000'000;

/** Inverts compressNodes(), for each Packing: fills the empty \a tree. For all input, \a most_nodes
 * bounds the memory and the time. What the data claims is compared with the data before memory is
 * allocated. \exception std::runtime_error If data is truncated or damaged, log-odds are not
 * finite, nodes are deeper than 16, or there are more than \a most_nodes nodes. \a tree is then
 * incomplete: discard it. */
void decompressNodes(std::string_view bytes, octomap::OcTree& tree,
                     size_t most_nodes = kMostCompressedNodes);

/** \overload
 * Inverts compressNodes() of a node: sets the value of \a node and makes the nodes below it.
 * \param[in] bytes The compressed nodes, at least one.
 * \param[in,out] tree The octree of the node.
 * \param[in,out] node A node without children.
 * \param[in] depth Depth of the node.
 * \param[in] most_nodes Largest number of nodes.
 * \return Number of nodes, with \a node.
 * \exception std::runtime_error As the other function, and if there is no node. */
size_t decompressNodes(std::string_view bytes, octomap::OcTree& tree, octomap::OcTreeNode& node,
                       unsigned depth, size_t most_nodes);

}  // namespace mrpt::fusion
