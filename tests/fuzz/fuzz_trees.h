// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/fuzz_target.h"

/** \file
 * Octrees for fuzz targets. */

namespace mrpt::fusion::fuzz {

/** Trees of few nodes: empty, one voxel, one coarse leaf, a small box with free space in it. */
std::vector<std::unique_ptr<octomap::OcTree>> smallTrees();

/** A tree of boxes that the input describes. Resolution in [1e-4, 1e6] m. */
std::unique_ptr<octomap::OcTree> treeFrom(Input& input);

/** An input that treeFrom() makes a furnished room of. */
void describeRoom(Output& output, double resolution);

/** The bytes in the format of xz, as compressNodes() can write it, but fast: what is inside can be
 * fuzzed in spite of the checksum. */
std::string xzCompressed(std::string_view bytes);

/** Inverse of xzCompressed() for valid data. */
std::string xzDecompressed(std::string_view bytes);

}  // namespace mrpt::fusion::fuzz
