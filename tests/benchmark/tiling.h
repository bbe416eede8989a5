// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "map_pair.h"

/** \file Large maps that are like a real one everywhere: copies of it, side by side. */

namespace mrpt::fusion::benchmark {

/** Where the copies are; lengths in finest voxels. */
struct Tiles {
  /** Tiles begin and end at multiples of this (a power of two), so that no node of an octree of
   * this side or less belongs to two copies. */
  static constexpr uint32_t kBlock = 16;

  std::array<uint32_t, 3> first{};          ///< key of the lowest corner of the first tile
  std::array<uint32_t, 3> period{};         ///< from a copy to the next
  std::array<uint32_t, 3> copies{1, 1, 1};  ///< along each axis
};

/** nx x ny tiles, each as large as what the two maps of one grid know together; the first is where
 * the maps are. \exception std::out_of_range If they do not all fit into an octree. */
Tiles tilesFor(const octomap::OcTree& a, const octomap::OcTree& b, uint32_t nx, uint32_t ny);

/** A map, known space and all, once in each tile: the copy in tile (i, j) is moved by (i, j)
 * periods and holds the same log-odds. Time and memory: those of the result. */
std::unique_ptr<octomap::OcTree> tileMap(const octomap::OcTree& map, const Tiles& tiles);

/** Writes a pair of maps with the same true pose, each nx x ny copies of the given pair's. B is
 * copied in A's frame, so that the copies lie to each other as the two maps do, and moved back.
 * \exception std::exception If a map outgrows an octree, or cannot be written. */
void writeTiledPair(const MapPair& pair, uint32_t nx, uint32_t ny, const std::string& folder);

}  // namespace mrpt::fusion::benchmark
