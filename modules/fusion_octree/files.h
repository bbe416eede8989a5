// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <memory>
#include <string>
#include <string_view>

#include "fusion_base/files.h"

/** \file
 * OctoMap's file formats. This library has its own readers because OctoMap's readers trust the
 * file: a truncated `.ot` makes them recurse on uninitialised memory. The files are the same, byte
 * by byte.
 */

namespace mrpt::fusion {

/** True if the bytes begin like a `.ot` or a `.bt` file. */
bool isOcTreeFile(std::string_view bytes);

/** Reads the contents of a `.ot` or a `.bt` file. A `.ot` file gives all log-odds and the structure
 * of the octree, bit for bit; of a ColorOcTree only the occupancy is read. A `.bt` file gives two
 * values: the default clamping thresholds.
 * \exception std::runtime_error If the header is wrong, the data is truncated, the number of nodes
 * is wrong, nodes are deeper than 16, log-odds are not finite, or the tree has another type.
 */
std::unique_ptr<octomap::OcTree> parseOcTreeFile(std::string_view bytes);

/** Returns the contents of a `.ot` file: all log-odds and the structure of the octree. */
std::string toOtFile(const octomap::OcTree& tree);

/** Returns the contents of a `.bt` file: each voxel is occupied or free (maximum likelihood),
 * without probabilities, pruned. Unlike octomap's writeBinary() it does not change \a tree. */
std::string toBtFile(const octomap::OcTree& tree);

/** Writes a `.bt` file if the path ends in `.bt`, otherwise a `.ot` file. It writes the whole file
 * or nothing.
 * \exception std::runtime_error As writeFileAtomically(). */
void saveOcTree(const octomap::OcTree& tree, const std::string& path);

/** Returns the nodes in pre-order, as in the data part of a `.ot` file. Each node has its log-odds
 * (4 bytes, native float) and a mask of its children (1 byte). Empty for an empty octree. */
std::string serializeNodes(const octomap::OcTree& tree);
/** \overload
 * Writes the bytes to \a sink in pieces. */
void serializeNodes(const octomap::OcTree& tree, const ByteSink& sink);

/** Inverts serializeNodes(): fills the empty \a tree with the nodes.
 * \param[in] bytes All bytes of the nodes.
 * \param[in,out] tree An empty octree.
 * \param[in] extra_bytes_per_node Number of bytes to skip between log-odds and mask (3 for a
 * ColorOcTree).
 * \return Number of nodes.
 * \exception std::runtime_error As parseOcTreeFile(). \a tree is then incomplete: discard it.
 */
size_t parseNodes(std::string_view bytes, octomap::OcTree& tree, size_t extra_bytes_per_node = 0);

}  // namespace mrpt::fusion
