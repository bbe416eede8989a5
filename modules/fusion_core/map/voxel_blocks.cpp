// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Builds the index of voxels, the balls and the windows. */
#include "fusion_core/map/voxel_blocks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mrpt::fusion {
namespace {

/** Returns the indices of keys in the order of the octree. The result is empty for keys that
 * already have this order, which is the usual case. */
std::vector<uint32_t> inOctreeOrder(const std::vector<octomap::OcTreeKey>& keys) {
  std::vector<uint32_t> index;
  uint64_t last = 0;
  for (const octomap::OcTreeKey& key : keys) {
    const uint64_t order = octreeOrder(key);
    if (order < last) {
      index.resize(keys.size());
      std::iota(index.begin(), index.end(), 0);
      std::sort(index.begin(), index.end(), [&](uint32_t a, uint32_t b) {
        return octreeOrder(keys[a]) < octreeOrder(keys[b]);
      });
      break;
    }
    last = order;
  }
  return index;
}

/** True if two voxels are in the same cube with a side of 2^depth voxels. */
bool shareCube(const octomap::OcTreeKey& a, const octomap::OcTreeKey& b, int depth) {
  return ((a[0] ^ b[0]) | (a[1] ^ b[1]) | (a[2] ^ b[2])) >> depth == 0;
}

}  // namespace

/** Adds the next cell, in order. \a content is the index of its content. */
void VoxelBlocks::add(Cells& cells, Ranks& ranks, int cell, uint32_t content) {
  if (!cells.mask) cells.first = content;
  cells.mask |= uint64_t{1} << cell;
  ranks[static_cast<size_t>(cell)] = static_cast<uint8_t>(content - cells.first);
}

VoxelBlocks::VoxelBlocks(const std::vector<octomap::OcTreeKey>& keys)
    : voxels_(inOctreeOrder(keys)) {
  const auto keyAt = [&](size_t i) -> const octomap::OcTreeKey& {
    return keys[voxelAt(static_cast<uint32_t>(i))];
  };
  size_t blocks = 0, groups = 0;
  for (size_t i = 0; i < keys.size(); i++) {
    if (i > 0 && shareCube(keyAt(i), keyAt(i - 1), 2)) continue;
    blocks++;
    if (i == 0 || !shareCube(keyAt(i), keyAt(i - 1), 4)) groups++;
  }
  blocks_.reserve(blocks);
  ranks_.resize(blocks);
  places_.reserve(blocks);
  for (size_t i = 0; i < keys.size(); i++) {
    const octomap::OcTreeKey& k = keyAt(i);
    if (i == 0 || !shareCube(k, keyAt(i - 1), 2)) {
      blocks_.emplace_back();
      places_.push_back({k[0] >> 2, k[1] >> 2, k[2] >> 2});
    }
    add(blocks_.back(), ranks_[blocks_.size() - 1], cellOf(k[0], k[1], k[2]),
        static_cast<uint32_t>(i));
  }

  size_t capacity = 16;
  while (capacity < 2 * groups) capacity *= 2;
  slots_.resize(capacity);
  slot_ranks_.resize(capacity);
  slot_mask_ = capacity - 1;
  for (uint32_t b = 0; b < blocks_.size(); b++) {
    const auto& [x, y, z] = places_[b];
    const uint64_t key = keyOf(x >> 2, y >> 2, z >> 2);
    size_t slot = hash(key) & slot_mask_;
    while (slots_[slot].first != kNone && slots_[slot].key != key) slot = (slot + 1) & slot_mask_;
    slots_[slot].key = key;
    add(slots_[slot], slot_ranks_[slot], cellOf(x, y, z), b);
  }
  linkBlocks();
}

void VoxelBlocks::linkBlocks() {
  static const Ball beside(1.8);  // here in blocks: the blocks around a block
  beside_.resize(blocks_.size());
  Place group{};
  std::array<const Slot*, 27> groups{};  // the group and its 26 neighbours, x fastest
  for (uint32_t b = 0; b < blocks_.size(); b++) {
    const auto& [x, y, z] = places_[b];
    const Place own{x >> 2, y >> 2, z >> 2};
    if (b == 0 || own != group) {
      group = own;
      auto next = groups.begin();
      for (int dz = -1; dz <= 1; dz++)
        for (int dy = -1; dy <= 1; dy++)
          for (int dx = -1; dx <= 1; dx++) *next++ = find(own[0] + dx, own[1] + dy, own[2] + dz);
    }
    beside_[b].fill(kNone);
    const auto cell = static_cast<size_t>(cellOf(x, y, z));
    for (size_t i = beside.part_[cell]; i < beside.part_[cell + 1]; i++) {
      const Slot* slot = groups[beside.parts_[i].beside];
      if (!slot) continue;
      for (uint64_t found = slot->mask & beside.parts_[i].mask; found; found &= found - 1) {
        const uint32_t other = contentOf(*slot, __builtin_ctzll(found));
        const auto& [ox, oy, oz] = places_[other];
        beside_[b][besideOf(ox - x, oy - y, oz - z)] = other;
      }
    }
  }
}

VoxelBlocks::Ball::Ball(double radius, double beyond)
    : radius_(static_cast<int>(radius)), reach_((radius_ + 3) / 4), part_{} {
  const auto most = static_cast<int>(radius * radius);
  const int least = beyond < 0 ? -1 : static_cast<int>(beyond * beyond);
  std::vector<int> root(static_cast<size_t>(most) + 1);
  for (size_t i = 0; i < root.size(); i++)
    root[i] = static_cast<int>(std::sqrt(static_cast<double>(i)));
  // The largest whole coordinate on an axis if the other two axes use \a used of the squared
  // radius.
  const auto left = [&](int squared, int used) {
    return squared < used ? -1 : root[static_cast<size_t>(squared - used)];
  };
  masks_.assign(64 * static_cast<size_t>(std::pow(2 * reach_ + 1, 3)), 0);
  // Fills the masks row by row along x.
  const size_t side = 2 * static_cast<size_t>(reach_) + 1;
  std::vector<uint64_t> along(4 * side);  // masks of a row from each x, by block
  for (int dz = -radius_; dz <= radius_; dz++)
    for (int dy = -radius_; dy <= radius_; dy++) {
      const int far = left(most, dy * dy + dz * dz), near = left(least, dy * dy + dz * dz);
      if (far < 0) continue;
      for (int x = 0; x < 4; x++)
        for (int bx = -reach_; bx <= reach_; bx++) {
          uint64_t cells = range(0, x - far - 4 * bx, x + far - 4 * bx);
          if (near >= 0) cells &= ~range(0, x - near - 4 * bx, x + near - 4 * bx);
          along[static_cast<size_t>(x) * side + static_cast<size_t>(bx + reach_)] = cells;
        }
      for (size_t cell = 0; cell < 64; cell++) {
        const auto [x, from_y, from_z] = coordinatesOf(static_cast<int>(cell));
        const int y = from_y + dy, z = from_z + dz;
        const uint64_t row = range(1, y & 3, y & 3) & range(2, z & 3, z & 3);
        uint64_t* masks = &masks_[index(cell, -reach_, y >> 2, z >> 2)];
        for (size_t i = 0; i < side; i++)
          masks[i] |= along[static_cast<size_t>(x) * side + i] & row;
      }
    }
  if (reach_ > 1) return;
  for (size_t cell = 0; cell < 64; cell++) {
    const auto [x, y, z] = coordinatesOf(static_cast<int>(cell));
    for (int bz = -reach_; bz <= reach_; bz++)
      for (int by = -reach_; by <= reach_; by++)
        for (int bx = -reach_; bx <= reach_; bx++)
          if (const uint64_t mask = of(cell, bx, by, bz)) {
            const auto lowest = [](int block, int at) {
              return static_cast<int8_t>(4 * block - at);
            };
            parts_.push_back({mask,
                              static_cast<uint8_t>(besideOf(bx, by, bz)),
                              {lowest(bx, x), lowest(by, y), lowest(bz, z)}});
          }
    part_[cell + 1] = parts_.size();
  }
}

bool VoxelBlocks::anyAround(const Place& place, const Ball& ball) const {
  bool any = false;
  forEachPart(place, ball, [&](uint32_t, uint64_t, const Offset&) { return any = true; });
  return any;
}

VoxelBlocks::Surroundings::Surroundings(const VoxelBlocks& blocks, double radius) {
  if (blocks.blocks_.empty()) return;
  Place low = blocks.places_.front(), high = low;
  for (const Place& place : blocks.places_)
    for (unsigned axis = 0; axis < 3; axis++) {
      low[axis] = std::min(low[axis], place[axis]);
      high[axis] = std::max(high[axis], place[axis]);
    }
  constexpr double kMostPerBlock = 32;
  constexpr unsigned kWholeTree = 18;  // largest shift_
  const double most = kMostPerBlock * static_cast<double>(blocks.blocks_.size() + 1000);
  int reach = 0;
  const auto cubes = [&] {
    reach = (static_cast<int>(radius) + (1 << shift_) - 1) >> shift_;
    double n = 1;
    for (unsigned axis = 0; axis < 3; axis++) {
      low_[axis] = (low[axis] >> (shift_ - 2)) - reach;
      size_[axis] = (high[axis] >> (shift_ - 2)) + reach - low_[axis] + 1;
      n *= size_[axis];
    }
    return n;
  };
  while (cubes() > most && shift_ < kWholeTree) shift_++;

  const auto row = static_cast<size_t>(size_[0]), layer = row * static_cast<size_t>(size_[1]);
  near_.resize(layer * static_cast<size_t>(size_[2]));
  for (const Place& place : blocks.places_) {
    const auto at = [&](unsigned axis) {
      return static_cast<size_t>((place[axis] >> (shift_ - 2)) - low_[axis]);
    };
    near_[at(2) * layer + at(1) * row + at(0)] = 1;
  }
  // Spreads along each axis in turn. Nothing passes the end of a row: rows end in empty cubes.
  for (const size_t step : {size_t{1}, row, layer}) {
    const std::vector<uint8_t> from = near_;
    for (size_t far = step; far <= static_cast<size_t>(reach) * step; far += step)
      for (size_t i = far; i < near_.size(); i++) {
        near_[i] |= from[i - far];
        near_[i - far] |= from[i];
      }
  }
}

VoxelBlocks::Window::Window(const VoxelBlocks& blocks, int reach)
    : blocks_(blocks),
      reach_((reach + 3) / 4),
      side_(2 * reach_ + 1),
      seen_(static_cast<size_t>(side_ * side_ * side_)) {}

void VoxelBlocks::Window::moveTo(const Place& place) {
  places_++;
  for (unsigned axis = 0; axis < 3; axis++) {
    at_[axis] = 4 * reach_ + (place[axis] & 3);
    low_[axis] = (place[axis] >> 2) - reach_;
  }
}

}  // namespace mrpt::fusion
