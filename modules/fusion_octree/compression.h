// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <string>
#include <string_view>

/** \file
 * Octrees in few bytes, for thin links: half of what gzip makes of a `.ot` file.
 */

namespace mrpt::fusion {

/** The nodes of a tree, compressed: every value and the structure of the tree, bit for bit.
 *
 * What is alike goes together before it is compressed (LZMA, with a checksum): the masks of
 * children in pre-order, then the leaves' values as places in a table of those that occur. Inner
 * nodes that hold their children's maximum, as OctoMap keeps them, take no room. About 3 bits a
 * leaf, and 2 s for a million of them. \exception std::length_error If the tree has more than
 * kMostCompressedNodes. */
std::string compressNodes(const octomap::OcTree& tree);

/** Inverse of compressNodes(): fills the empty \a tree.
 * \exception std::runtime_error Saying what is wrong: truncated or damaged data, log-odds that are
 * not finite, nodes deeper than 16; \a tree is then half-filled, discard it. Memory is bounded by
 * kMostCompressedNodes, whatever the data says. */
void decompressNodes(std::string_view bytes, octomap::OcTree& tree);

/** 50 times the nodes of a large building at 0.1 m. */
constexpr size_t kMostCompressedNodes = 50'000'000;

}  // namespace mrpt::fusion
