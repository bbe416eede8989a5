// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <memory>
#include <string>
#include <string_view>

#include "fusion_base/files.h"

/** \file
 * OctoMap's file formats. Reading is our own because OctoMap's readers trust the file: a truncated
 * `.ot` makes them recurse on uninitialised memory. Files are the same, byte by byte.
 */

namespace mrpt::fusion {

/** True if the bytes begin as a `.ot` or a `.bt` file does. */
bool isOcTreeFile(std::string_view bytes);

/** Reads the contents of a `.ot` (every log-odds value and the tree's structure, bit for bit; of a
 * ColorOcTree, the occupancy) or of a `.bt` file (two values: the default clamping thresholds).
 * \exception std::runtime_error Saying what is wrong: header, truncation, node count, nodes deeper
 * than 16, log-odds that are not finite, another tree type.
 */
std::unique_ptr<octomap::OcTree> parseOcTreeFile(std::string_view bytes);

/** The contents of a `.ot` file: every log-odds value and the structure of the tree. */
std::string toOtFile(const octomap::OcTree& tree);

/** The contents of a `.bt` file: each voxel occupied or free (maximum likelihood), probabilities
 * lost, pruned. Unlike octomap's writeBinary() it leaves \a tree as it is. */
std::string toBtFile(const octomap::OcTree& tree);

/** Writes a `.bt` file if the path ends so, else a `.ot`; all of it or nothing.
 * \exception std::runtime_error As writeFileAtomically(). */
void saveOcTree(const octomap::OcTree& tree, const std::string& path);

/** The nodes in pre-order, as in the data part of a `.ot` file: log-odds (4 bytes, native float)
 * and a mask of its children (1 byte) for each. Empty for an empty tree. */
std::string serializeNodes(const octomap::OcTree& tree);
/** \overload
 * Gives the bytes to \a sink in pieces. */
void serializeNodes(const octomap::OcTree& tree, const ByteSink& sink);

/** Inverse of serializeNodes(): fills the empty \a tree with the nodes read.
 * \param[in] bytes All of them. \param[in,out] tree Empty.
 * \param[in] extra_bytes_per_node Bytes to skip between log-odds and mask (a ColorOcTree's 3).
 * \return Number of nodes.
 * \exception std::runtime_error As parseOcTreeFile(); \a tree is then half-filled, discard it.
 */
size_t parseNodes(std::string_view bytes, octomap::OcTree& tree, size_t extra_bytes_per_node = 0);

}  // namespace mrpt::fusion
