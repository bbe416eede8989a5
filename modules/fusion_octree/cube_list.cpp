// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Collects the cubes of a map. */
#include "fusion_octree/cube_list.h"

#include <algorithm>
#include <utility>

namespace mrpt::fusion {
namespace {

/** Returns the number of the child of a cube's ancestor in which the cube lies.
 * \param[in] depth Depth of the child. */
unsigned childNumber(const OcTreeCube& cube, unsigned depth) {
  const unsigned bit = OcTreeCube::kMaxDepth - depth;
  return (cube.key[0] >> bit & 1U) | (cube.key[1] >> bit & 1U) << 1U |
         (cube.key[2] >> bit & 1U) << 2U;
}

OcTreeCube parentOf(const OcTreeCube& cube) {
  const unsigned height = OcTreeCube::kMaxDepth - cube.depth + 1;
  OcTreeCube parent{{0, 0, 0}, cube.depth - 1};
  for (unsigned axis = 0; axis < 3; axis++)
    parent.key[axis] = static_cast<octomap::key_type>(cube.key[axis] >> height << height);
  return parent;
}

}  // namespace

void CubeList::addLeaf(const OcTreeCube& cube, float log_odds) {
  cubes_.push_back({cube, log_odds, nullptr});
  pruneLast();
}

void CubeList::addBlock(const OcTreeCube& cube, const VoxelBlock& block) {
  if (block.known == 0) return;
  VoxelBlock& added = blocks_.add();
  added = block;
  bool is_leaf = true;
  for (unsigned i = 0; i < 8; i++) {
    float* values = &added.value[size_t{8} * i];
    if (added.isUniformChild(i))
      std::fill(values + 1, values + 8, values[0]);
    else
      is_leaf = false;
    is_leaf = is_leaf && values[0] == added.value[0];
  }
  if (!is_leaf) {
    cubes_.push_back({cube, 0, &added});
    return;
  }
  const float log_odds = added.value[0];
  blocks_.removeLast();
  addLeaf(cube, log_odds);
}

void CubeList::addCube(const ListedCube& cube) {
  cubes_.push_back(cube);
  if (!cube.block) pruneLast();
}

void CubeList::keepBlocksOf(CubeList&& other) {
  blocks_.takeAll(std::move(other.blocks_));
  other = CubeList();
}

void CubeList::addAll(CubeList&& others) {
  for (const ListedCube& cube : others.cubes_) addCube(cube);
  keepBlocksOf(std::move(others));
}

/** Replaces 8 equal siblings at the end by their parent, as often as possible. */
void CubeList::pruneLast() {
  while (cubes_.size() >= 8) {
    const ListedCube* siblings = &cubes_[cubes_.size() - 8];
    const unsigned depth = siblings[7].cube.depth;
    if (depth == 0) return;
    const OcTreeCube parent = parentOf(siblings[7].cube);
    if (!parent.contains(siblings[0].cube)) return;
    for (unsigned i = 0; i < 8; i++)
      if (siblings[i].block || siblings[i].cube.depth != depth ||
          siblings[i].log_odds != siblings[0].log_odds)
        return;
    cubes_.resize(cubes_.size() - 7);
    cubes_.back().cube = parent;
  }
}

CubeRange CubeRange::in(unsigned i, const OcTreeCube& child) const {
  if (empty() || begin->cube.depth < child.depth) return *this;
  const auto before = [&child](unsigned number) {
    return
        [number, &child](const ListedCube& c) { return childNumber(c.cube, child.depth) < number; };
  };
  const ListedCube* first = std::partition_point(begin, end, before(i));
  return {first, std::partition_point(first, end, before(i + 1))};
}

}  // namespace mrpt::fusion
