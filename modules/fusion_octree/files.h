// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "fusion_base/files.h"

/** \file
 * OctoMap's file formats. This library has its own readers because OctoMap's readers trust the
 * file: a truncated `.ot` makes them recurse on uninitialised memory. The files are the same, byte
 * by byte.
 */

namespace mrpt::fusion {

/** True if the bytes begin like a `.ot` or a `.bt` file, of OctoMap 1.0 and later or of 2010. */
bool isOcTreeFile(std::string_view bytes);

/** Reads the contents of a `.ot` or a `.bt` file, which may be gzip data. A `.ot` file gives all
 * log-odds and the structure of the octree, bit for bit. A `.bt` file gives two values: the default
 * clamping thresholds. All that OctoMap reads is read:
 *  - `.ot` of OcTree, OcTreeStamped and ColorOcTree (without the colours), `.bt` of any type;
 *  - a number of nodes that is not the number in the header: the data decides. 0 is an empty map;
 *  - infinite log-odds, which become the default clamping thresholds.
 *
 * \param[in] bytes The file.
 * \param[out] notes Sentences about what differs from the file. May be null.
 * \exception std::runtime_error If the header is wrong, the resolution is not in [1e-4, 1e6] m, the
 * data is truncated, nodes are deeper than 16, log-odds are NaN, the tree has another type, or
 * compressed data needs more memory than a file of its size can need. */
std::unique_ptr<octomap::OcTree> parseOcTreeFile(std::string_view bytes,
                                                 std::vector<std::string>* notes = nullptr);

/** Reads the nodes of an octree without a header, as the data of octomap_msgs/Octomap: full or
 * binary, with or without colours. The layout must fit all bytes.
 * \return Null if the bytes are no such data.
 * \exception std::runtime_error If the resolution is not in [1e-4, 1e6] m, or gzip data is damaged.
 */
std::unique_ptr<octomap::OcTree> parseRawOcTree(std::string_view bytes, double resolution,
                                                std::vector<std::string>* notes = nullptr);

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
 * \return Number of nodes.
 * \exception std::runtime_error If the data is truncated, nodes are deeper than 16, or log-odds are
 * not finite. \a tree is then incomplete: discard it. */
size_t parseNodes(std::string_view bytes, octomap::OcTree& tree);

}  // namespace mrpt::fusion
