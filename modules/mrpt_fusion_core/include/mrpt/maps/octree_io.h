// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <functional>
#include <memory>
#include <string>
#include <string_view>

/** \file
 * OctoMap's file formats. Reading is our own because OctoMap's readers trust the file: a truncated
 * `.ot` makes them recurse on uninitialised memory. Files are the same, byte by byte.
 */

namespace mrpt::maps {

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

/** The first bytes of a file, to tell its kind by. \exception std::runtime_error As
 * readFileBytes(). */
std::string beginningOf(const std::string& path);

/** The nodes in pre-order, as in the data part of a `.ot` file: log-odds (4 bytes, native float)
 * and a mask of its children (1 byte) for each. Empty for an empty tree. */
std::string serializeNodes(const octomap::OcTree& tree);

/** Inverse of serializeNodes(): fills the empty \a tree with the nodes read.
 * \param[in] bytes All of them. \param[in,out] tree Empty.
 * \param[in] extra_bytes_per_node Bytes to skip between log-odds and mask (a ColorOcTree's 3).
 * \return Number of nodes.
 * \exception std::runtime_error As parseOcTreeFile(); \a tree is then half-filled, discard it.
 */
size_t parseNodes(std::string_view bytes, octomap::OcTree& tree, size_t extra_bytes_per_node = 0);

/** Whole contents of a file. \exception std::runtime_error If it cannot be read, or is empty. */
std::string readFileBytes(const std::string& path);

/** Takes the bytes of a file in pieces, one after the other. */
using ByteSink = std::function<void(std::string_view)>;

/** Writes a file so that either all of it is there or nothing has changed: into a temporary file
 * beside \a path, or beside what a link of that name leads to, flushed, then renamed. A device or a
 * pipe is written to as it is.
 * \exception std::runtime_error With the system's reason (full disk, no such directory...). */
void writeFileAtomically(const std::string& path, std::string_view bytes);

/** \overload
 * \param[in] path As above. \param[in] write Gives what it is called with all pieces of the file;
 * what it throws leaves nothing changed either. */
void writeFileAtomically(const std::string& path,
                         const std::function<void(const ByteSink&)>& write);

}  // namespace mrpt::maps
