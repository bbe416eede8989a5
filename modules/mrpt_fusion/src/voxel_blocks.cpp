// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/voxel_blocks.h>

#include <algorithm>
#include <cmath>

namespace mrpt::fusion {
namespace {

std::array<int, 3> placeOf(const octomap::OcTreeKey& k) {
  return {k[0] >> 2, k[1] >> 2, k[2] >> 2};
}

unsigned cellOf(const octomap::OcTreeKey& k) {
  return static_cast<unsigned>((k[0] & 3) | (k[1] & 3) << 2 | (k[2] & 3) << 4);
}

}  // namespace

VoxelBlocks::VoxelBlocks(const std::vector<octomap::OcTreeKey>& keys) {
  struct Entry {
    uint64_t block;
    uint32_t cell, voxel;
    bool operator<(const Entry& o) const {
      return block != o.block ? block < o.block : cell < o.cell;
    }
  };
  std::vector<Entry> entries(keys.size());
  for (size_t i = 0; i < keys.size(); i++)
    entries[i] = {keyOf(placeOf(keys[i])), cellOf(keys[i]), static_cast<uint32_t>(i)};
  std::sort(entries.begin(), entries.end());

  voxels_.reserve(keys.size());
  for (const Entry& e : entries) {
    if (blocks_.empty() || keyOf(blocks_.back().place) != e.block) {
      blocks_.emplace_back();
      blocks_.back().first = static_cast<uint32_t>(voxels_.size());
      blocks_.back().place = placeOf(keys[e.voxel]);
    }
    Block& block = blocks_.back();
    block.mask |= uint64_t{1} << e.cell;
    block.rank[e.cell] = static_cast<uint8_t>(voxels_.size() - block.first);
    voxels_.push_back(e.voxel);
  }

  size_t capacity = 16;
  while (capacity < 2 * blocks_.size()) capacity *= 2;
  slots_.resize(capacity);
  slot_mask_ = capacity - 1;
  for (uint32_t b = 0; b < blocks_.size(); b++) {
    const uint64_t key = keyOf(blocks_[b].place);
    size_t slot = hash(key) & slot_mask_;
    while (slots_[slot].block != kNone) slot = (slot + 1) & slot_mask_;
    slots_[slot] = {key, b};
  }
}

VoxelBlocks::Ball::Ball(double radius)
    : reach_(static_cast<int>(std::ceil(std::floor(radius) / 4))) {
  const double squared_radius = radius * radius;
  for (int bz = -reach_; bz <= reach_; bz++)
    for (int by = -reach_; by <= reach_; by++)
      for (int bx = -reach_; bx <= reach_; bx++) {
        auto& masks = masks_.emplace_back();
        for (int from = 0; from < 64; from++)
          for (int to = 0; to < 64; to++) {
            const int x = 4 * bx + (to & 3) - (from & 3);
            const int y = 4 * by + ((to >> 2) & 3) - ((from >> 2) & 3);
            const int z = 4 * bz + (to >> 4) - (from >> 4);
            if (x * x + y * y + z * z <= squared_radius)
              masks[static_cast<size_t>(from)] |= uint64_t{1} << to;
          }
      }
}

std::vector<VoxelBlocks::Near> VoxelBlocks::near(const Block& block, const Ball& ball) const {
  std::vector<Near> blocks_near;
  const auto* masks = ball.masks_.data();
  const int reach = ball.reach_;
  for (int z = -reach; z <= reach; z++)
    for (int y = -reach; y <= reach; y++)
      for (int x = -reach; x <= reach; x++, masks++)
        if (const Block* other = find({block.place[0] + x, block.place[1] + y, block.place[2] + z}))
          blocks_near.push_back({other, masks, {4 * x, 4 * y, 4 * z}});
  return blocks_near;
}

}  // namespace mrpt::fusion
