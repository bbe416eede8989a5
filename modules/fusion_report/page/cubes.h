// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "fusion_octree/build.h"

/** \file
 * Cubes of an octree for the picture of a page: few enough to draw, and small as bytes. */

namespace mrpt::fusion {

/** A cube with one byte: a value (see valueOf()) or a mask of faces. */
struct PageCube {
  OcTreeCube cube;    ///< Place and size
  uint8_t value = 0;  ///< Value or mask
};

/** Distinct cubes of one grid, in the order of the octree. */
struct PageCubes {
  double resolution = 0;        ///< Side of a finest voxel, m
  std::vector<PageCube> cubes;  ///< The cubes
};

/** Returns log-odds as a byte: steps of 1/16, shifted by 128. */
uint8_t valueOf(float log_odds);

/** Returns the occupied leaves of a map with their log-odds. Cost: O(nodes). */
PageCubes occupiedCubes(const octomap::OcTree& map);

/** Returns the free leaves that border on unknown space. The value is a mask of the faces that do:
 * bit 2 k for the lower face of axis k, bit 2 k + 1 for the upper face. Cost: O(nodes). */
PageCubes boundaryOfFreeSpace(const octomap::OcTree& map);

/** Returns at most \a most cubes: the level of the octree is the finest that has so few. A coarser
 * cube has the highest value of the cubes in it. \param[in] are_masks If true, the values are
 * masks, and a coarser cube has the faces of all cubes in it. Cost: O(cubes). */
PageCubes coarsened(PageCubes cubes, size_t most, bool are_masks = false);

/** Cubes as bytes. */
struct PackedCubes {
  /** Nodes, depth first: 16 bits each (little endian), 2 bits for each child. 0: nothing, 1: a
   * cube, 2: a node, which follows. */
  std::string tree;
  std::string values;  ///< Byte of each cube, in the order of the tree
};
/** Packs cubes: about 1.3 bytes for each cube of a surface. Cost: O(cubes). */
PackedCubes packed(const PageCubes& cubes);

}  // namespace mrpt::fusion
