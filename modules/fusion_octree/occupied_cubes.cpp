// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Lists occupied voxels in a hash table of blocks. */
#include "fusion_octree/occupied_cubes.h"

#include <algorithm>

namespace mrpt::fusion {
namespace {

/** Returns the occupied voxels of a cube; for a leaf, all or none. */
uint64_t occupiedIn(const ListedCube& cube, float threshold) {
  if (!cube.block) return cube.log_odds >= threshold ? ~uint64_t{0} : 0;
  uint64_t occupied = 0;
  for (unsigned i = 0; i < VoxelBlock::kVoxels; i++)
    occupied |= uint64_t{cube.block->value[i] >= threshold} << i;
  return occupied & cube.block->known;
}

}  // namespace

OccupiedCubes::OccupiedCubes(const CubeList& cubes, float threshold) {
  size_t size = 16;
  while (size < 2 * cubes.cubes().size()) size *= 2;
  entries_.resize(size);
  for (const ListedCube& c : cubes.cubes()) {
    const uint64_t occupied = occupiedIn(c, threshold);
    if (!occupied) continue;
    add(placeOf(c.cube.key, c.cube.depth), occupied);
    if (c.cube.depth < VoxelBlock::kDepth &&
        std::find(depths_.begin(), depths_.end(), c.cube.depth) == depths_.end())
      depths_.push_back(c.cube.depth);
  }
}

void OccupiedCubes::add(uint64_t place, uint64_t voxels) {
  size_t slot = slotOf(place);
  while (entries_[slot].place) slot = (slot + 1) & (entries_.size() - 1);
  entries_[slot] = {place, voxels};
}

uint64_t OccupiedCubes::at(uint64_t place) const {
  size_t slot = slotOf(place);
  while (entries_[slot].place && entries_[slot].place != place)
    slot = (slot + 1) & (entries_.size() - 1);
  return entries_[slot].voxels;
}

uint64_t OccupiedCubes::voxelsIn(const octomap::OcTreeKey& key) const {
  uint64_t voxels = at(placeOf(key, VoxelBlock::kDepth));
  for (const unsigned depth : depths_) voxels |= at(placeOf(key, depth));
  return voxels;
}

}  // namespace mrpt::fusion
