// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <algorithm>
#include <string>

#include "fusion_octree/compression.h"
#include "mrpt_fusion_maps/archives/blobs.h"
#include "mrpt_fusion_maps/archives/guarded_archive.h"

/** \file
 * Compressed octrees in the archives of MRPT. */

namespace mrpt::fusion {

/** Fills an empty octree from the bytes of compressNodes(). Takes the nodes from the budget.
 * \exception std::exception As decompressNodes(). */
inline void unpackNodes(const std::string& packed, ReadingBudget& budget, octomap::OcTree& tree) {
  decompressNodes(packed, tree, std::min(kMostCompressedNodes, budget.mostNodes(packed.size())));
  budget.take(tree.size(), packed.size());
}

/** Reads the bytes of compressNodes() as a blob and fills an empty octree, see unpackNodes().
 * \return How the octree was packed. */
inline Packing readPackedNodes(GuardedArchive& in, octomap::OcTree& tree) {
  const std::string bytes = readBlob(in);
  unpackNodes(bytes, in.budget(), tree);
  return packingOf(bytes);
}

}  // namespace mrpt::fusion
