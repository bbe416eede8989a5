// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Computes the hash of the voxels of a map. */
#include "fusion_octree/voxel_hash.h"

#include <cstring>
#include <optional>

namespace mrpt::fusion {
namespace {
using octomap::OcTree;
using octomap::OcTreeNode;

/** Mixes a number into a hash (the finaliser of splitmix64). */
uint64_t mixed(uint64_t hash, uint64_t number) {
  uint64_t x = hash * 0x9e3779b97f4a7c15ULL + number + 0x632be59bd9b4e019ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

template <class To, class From>
To bitsOf(From value) {
  static_assert(sizeof(To) == sizeof(From));
  To bits;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

/** Hash of a cube. The hash of a cube with one value depends on the value only, so that pruning
 * does not change the hash of the cubes above. */
struct CubeHash {
  uint64_t hash;
  std::optional<uint32_t> uniform;  // bits of the only value
};

constexpr CubeHash kUnknown{0x5bd1e995, std::nullopt};

CubeHash uniformCube(uint32_t bits) { return {mixed(1, bits), bits}; }

CubeHash hashOf(const OcTree& map, const OcTreeNode& node) {
  if (!map.nodeHasChildren(&node)) return uniformCube(bitsOf<uint32_t>(node.getLogOdds()));
  uint64_t hash = 2;
  std::optional<uint32_t> first;
  bool is_uniform = true;
  for (unsigned i = 0; i < 8; i++) {
    const CubeHash child =
        map.nodeChildExists(&node, i) ? hashOf(map, *map.getNodeChild(&node, i)) : kUnknown;
    if (i == 0) first = child.uniform;
    is_uniform = is_uniform && child.uniform && child.uniform == first;
    hash = mixed(hash, child.hash);
  }
  return is_uniform ? uniformCube(*first) : CubeHash{hash, std::nullopt};
}

}  // namespace

uint64_t voxelHash(const OcTree& map) {
  const CubeHash root = map.getRoot() ? hashOf(map, *map.getRoot()) : kUnknown;
  return mixed(root.hash, bitsOf<uint64_t>(map.getResolution()));
}

}  // namespace mrpt::fusion
