// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Collects, thins and packs the cubes of a picture. */

#include "fusion_report/page/cubes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "fusion_base/parallel.h"
#include "fusion_octree/walk.h"

namespace mrpt::fusion {
namespace {

using Node = octomap::OcTreeNode;
constexpr unsigned kMaxDepth = OcTreeCube::kMaxDepth;

/** Returns the number of the child cube of depth + 1 in which a key lies, in OctoMap's order. */
unsigned childOf(const octomap::OcTreeKey& key, unsigned depth) {
  const unsigned bit = kMaxDepth - 1 - depth;
  return (key[0] >> bit & 1U) | (key[1] >> bit & 1U) << 1U | (key[2] >> bit & 1U) << 2U;
}

/** Returns the depth of the smallest cube that holds both keys. */
unsigned commonDepth(const octomap::OcTreeKey& a, const octomap::OcTreeKey& b) {
  const unsigned differ = static_cast<unsigned>(a[0] ^ b[0]) | static_cast<unsigned>(a[1] ^ b[1]) |
                          static_cast<unsigned>(a[2] ^ b[2]);
  return differ == 0 ? kMaxDepth : kMaxDepth - 32 + static_cast<unsigned>(__builtin_clz(differ));
}

/** The six sides of a cube. */
struct Side {
  unsigned axis;
  bool is_upper;
};

/** True if all of the cube that a node stands for is known at one of its sides. */
bool isKnownAt(const octomap::OcTree& map, const Node& node, const Side& side) {
  if (!map.nodeHasChildren(&node)) return true;
  for (unsigned i = 0; i < 8; i++) {
    if ((i >> side.axis & 1U) != (side.is_upper ? 1U : 0U)) continue;
    if (!map.nodeChildExists(&node, i) || !isKnownAt(map, *map.getNodeChild(&node, i), side))
      return false;
  }
  return true;
}

/** True if all space on the other side of a cube's face is known. */
bool isKnownBeyond(const octomap::OcTree& map, const OcTreeCube& cube, const Side& side) {
  octomap::OcTreeKey key = cube.key;
  const uint32_t at = key[side.axis], step = cube.side();
  if (side.is_upper ? at + step > 0xffff : at < step) return false;  // end of the grid
  key[side.axis] = static_cast<octomap::key_type>(side.is_upper ? at + step : at - step);
  const Node* node = map.getRoot();
  for (unsigned depth = 0; depth < cube.depth; depth++) {
    if (!map.nodeHasChildren(node)) return true;
    const unsigned i = childOf(key, depth);
    if (!map.nodeChildExists(node, i)) return false;
    node = map.getNodeChild(node, i);
  }
  return isKnownAt(map, *node, {side.axis, !side.is_upper});
}

/** Packs the cubes [begin, end) below a node. */
void packNode(const PageCube* begin, const PageCube* end, unsigned depth, PackedCubes& out) {
  const size_t at = out.tree.size();
  out.tree.append(2, '\0');
  unsigned mask = 0;
  while (begin != end) {
    const unsigned i = childOf(begin->cube.key, depth);
    const PageCube* next = std::find_if(
        begin, end, [&](const PageCube& c) { return childOf(c.cube.key, depth) != i; });
    const bool is_cube = begin->cube.depth <= depth + 1;
    mask |= (is_cube ? 1U : 2U) << (2 * i);
    if (is_cube)
      out.values += static_cast<char>(begin->value);
    else
      packNode(begin, next, depth + 1, out);
    begin = next;
  }
  out.tree[at] = static_cast<char>(mask & 0xffU);
  out.tree[at + 1] = static_cast<char>(mask >> 8U);
}

}  // namespace

uint8_t valueOf(float log_odds) {
  const float value = std::round(16 * log_odds) + 128;
  return static_cast<uint8_t>(value > 0 ? std::min(value, 255.0F) : 0);  // 0 for NaN, too
}

PageCubes occupiedCubes(const octomap::OcTree& map) {
  PageCubes result{map.getResolution(), {}};
  forEachLeaf(map, [&](const OcTreeCube& cube, const Node& node) {
    if (map.isNodeOccupied(node)) result.cubes.push_back({cube, valueOf(node.getLogOdds())});
  });
  return result;
}

PageCubes boundaryOfFreeSpace(const octomap::OcTree& map) {
  PageCubes result{map.getResolution(), {}};
  auto& cubes = result.cubes;
  forEachLeaf(map, [&](const OcTreeCube& cube, const Node& node) {
    if (!map.isNodeOccupied(node)) cubes.push_back({cube, 0});
  });
  constexpr size_t kCubesOfAThread = 1000;
  forEachIndex(cubes.size(), kCubesOfAThread, [&](size_t i) {
    for (unsigned face = 0; face < 6; face++)
      if (!isKnownBeyond(map, cubes[i].cube, {face / 2, face % 2 == 1}))
        cubes[i].value = static_cast<uint8_t>(cubes[i].value | 1U << face);
  });
  cubes.erase(std::remove_if(cubes.begin(), cubes.end(), [](auto& c) { return c.value == 0; }),
              cubes.end());
  return result;
}

PageCubes coarsened(PageCubes result, size_t most, bool are_masks) {
  auto& cubes = result.cubes;
  // Neighbours in the order become one cube at the depth of their common cube, or less.
  std::array<size_t, kMaxDepth + 1> joined{};
  for (size_t i = 1; i < cubes.size(); i++)
    joined[commonDepth(cubes[i - 1].cube.key, cubes[i].cube.key)]++;
  unsigned depth = kMaxDepth;
  for (size_t left = cubes.size(); left > most && depth > 1;) left -= joined[--depth];
  if (depth == kMaxDepth) return result;
  size_t n = 0;
  for (PageCube c : cubes) {
    if (c.cube.depth > depth) {
      for (unsigned axis = 0; axis < 3; axis++)
        c.cube.key[axis] = static_cast<octomap::key_type>(
            c.cube.key[axis] >> (kMaxDepth - depth) << (kMaxDepth - depth));
      c.cube.depth = depth;
    }
    if (n > 0 && cubes[n - 1].cube.contains(c.cube)) {
      uint8_t& value = cubes[n - 1].value;
      value = are_masks ? static_cast<uint8_t>(value | c.value) : std::max(value, c.value);
    } else {
      cubes[n++] = c;
    }
  }
  cubes.resize(n);
  return result;
}

PackedCubes packed(const PageCubes& cubes) {
  PackedCubes result;
  if (cubes.cubes.empty()) return result;
  if (cubes.cubes.front().cube.depth > 0) {
    packNode(cubes.cubes.data(), cubes.cubes.data() + cubes.cubes.size(), 0, result);
  } else {  // the whole grid: a node of 8 cubes
    result.tree = "\x55\x55";
    result.values.assign(8, static_cast<char>(cubes.cubes.front().value));
  }
  return result;
}

}  // namespace mrpt::fusion
